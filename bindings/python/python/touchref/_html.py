"""Results in notebooks."""

from __future__ import annotations

import base64
from html import escape
from typing import Any, Optional


def of_solution(document: dict[str, Any], picture: Optional[str]) -> str:
    """The picture and the figures of a solution."""
    units = document["units"]
    frame, trust = document["frame"], document["trust"]
    spread = _standard_deviations(document)
    rows = [
        (axis, f"{value:.6g} {escape(units)}", "" if u is None else f"&plusmn; {u:.2g}")
        for axis, value, u in zip("xyz", frame["origin"], spread)
    ]
    quaternion = ", ".join(f"{value:.6f}" for value in frame["quaternion_xyzw"])
    turned = [u for u in spread[3:] if u is not None]
    rows.append(("q<sub>xyzw</sub>", quaternion, f"&plusmn; {max(turned):.2g} rad" if turned else ""))
    up_to = trust["up_to_sigma"]
    stands = f"from {trust['from_sigma'] or 0.0:.2g} " + ("on" if up_to is None else f"to {up_to:.2g} {escape(units)}")
    rows.append(("stands for sigma", stands, "" if trust["sigma"] is None else f"stated {trust['sigma']:.2g}"))
    if document["p_value"] is not None:
        freedom = document["degrees_of_freedom"]
        rows.append(("chi-square", f"{document['chi_square']:.3g} of {freedom}", f"p = {document['p_value']:.2g}"))
    roots = len(document["roots"])
    touches = f"{len(document['touches'])} touches, solver {escape(document['solver'])}"
    rows.append(("from", touches, f"{roots} root{'s' if roots != 1 else ''}" if roots else ""))
    cell = 'style="text-align:left;padding:2px 10px 2px 0"'
    table = "".join(f"<tr>{''.join(f'<td {cell}>{text}</td>' for text in row)}</tr>" for row in rows)
    warnings = "".join(f"<div>Warning: {escape(one['message'])}</div>" for one in document["warnings"])
    image = ""
    if picture is not None:
        # As an image it keeps its own style, and none of the notebook's.
        data = base64.b64encode(picture.encode()).decode()
        style = "background:#fff;border-radius:4px;max-width:100%"
        image = f'<img alt="fixture, frame and touches" width="340" style="{style}" src="data:image/svg+xml;base64,{data}"/>'
    return (
        f'<div><b>Frame of {escape(document["fixture"]["kind"])}</b>{warnings}'
        '<div style="display:flex;flex-wrap:wrap;gap:16px;align-items:center">'
        f"{image}<table>{table}</table></div></div>"
    )


def _standard_deviations(document: dict[str, Any]) -> list[Optional[float]]:
    covariance = document["covariance"]
    if covariance is None:
        return [None] * 6
    return [max(covariance["matrix"][i][i], 0.0) ** 0.5 for i in range(6)]
