"""Results are those of the command line, to the last bit."""

from __future__ import annotations

import json
import re
from collections import Counter
from pathlib import Path
from typing import Any

import measurements
import numpy as np
import pyarrow as pa
import pyarrow.parquet
import pytest
import touchref

KINDS = list(measurements.fixtures())
AXES = ["x", "y", "z", "rx", "ry", "rz"]


def table(kind: str) -> pa.Table:
    """The placements of a fixture, one row a touch."""
    rows: dict[str, list[Any]] = {name: [] for name in ("placement", "surface", "x", "y", "z", "sigma", "i", "j", "k")}
    for placement in measurements.placements(kind):
        for index, (label, at) in enumerate(zip(placement.labels, placement.touches)):
            approach = placement.approaches[index] if placement.approaches else (None, None, None)
            values = (placement.name, label, *at, placement.sigma, *approach)
            for column, value in zip(rows.values(), values):
                column.append(value)
    numbers = {name: pa.array(rows[name], pa.float64(), from_pandas=False) for name in list(rows)[2:]}
    return pa.table({"placement": rows["placement"], "surface": rows["surface"], **numbers})


def write_measurement(path: Path, fixture: touchref.Fixture) -> None:
    """The measurement file that states fixture and probe."""
    kind = {"kind": fixture.kind, **fixture.parameters}
    probe = {"tip_radius": measurements.TIP_RADIUS, "sigma": measurements.SIGMA}
    path.write_text(json.dumps({"units": "mm", "fixture": kind, "probe": probe}), encoding="utf-8")


@pytest.fixture(scope="session")
def frames(command: Any, tmp_path_factory: pytest.TempPathFactory) -> dict[str, pa.Table]:
    """What ``touchref batch`` makes of the thousand measurements, by fixture."""
    folder = tmp_path_factory.mktemp("batch")
    found = {}
    for kind, (fixture, _, _) in measurements.fixtures().items():
        measurement, touches, output = folder / "m.json", folder / "t.parquet", folder / f"{kind}.parquet"
        write_measurement(measurement, fixture)
        pa.parquet.write_table(table(kind), touches)
        status, printed = command("batch", touches, "--measurement", measurement, "-o", output)
        assert status == 0, printed
        found[kind] = pa.parquet.read_table(output)
    return found


def bits(values: Any) -> list[int]:
    """The very bits of numbers; ``None`` counts as the NaN of numpy."""
    found: list[int] = np.array([np.nan if v is None else v for v in values], dtype=np.float64).view(np.int64).tolist()
    return found


def row_of(solution: touchref.Solution) -> list[Any]:
    """The numbers of a row of ``batch``."""
    covariance = solution.covariance
    upper = [None] * 21 if covariance is None else covariance[np.triu_indices(6)].tolist()
    return [
        *solution.frame.origin,
        *solution.frame.quaternion,
        solution.chi_square,
        solution.degrees_of_freedom,
        solution.p_value,
        solution.observability.condition,
        *upper,
    ]


NUMBERS = ["x", "y", "z", "qx", "qy", "qz", "qw", "chi_square", "degrees_of_freedom", "p_value", "condition"]
NUMBERS += [f"cov_{AXES[i]}_{AXES[j]}" for i in range(6) for j in range(i, 6)]


def test_a_thousand_measurements(frames: dict[str, pa.Table]) -> None:
    """``locate`` on arrays and ``touchref batch`` on a file: every number, every code of a refusal."""
    statuses: Counter[str] = Counter()
    for kind, (fixture, _, _) in measurements.fixtures().items():
        rows = frames[kind].to_pylist()
        for placement, row in zip(measurements.placements(kind), rows):
            assert row["placement"] == placement.name
            own = placement.sigma
            try:
                solution = touchref.locate(
                    fixture,
                    np.array(placement.touches),
                    placement.labels,
                    tip_radius=measurements.TIP_RADIUS,
                    sigma=measurements.SIGMA if own is None else [own] * len(placement.labels),
                    approaches=placement.approaches,
                    solver=touchref.LeastSquares(margin="near"),
                )
            except touchref.TouchrefError as error:
                assert row["status"] == error.code, placement
                assert all(row[name] is None for name in NUMBERS), placement
            else:
                assert row["status"] == "ok", placement
                assert bits(row_of(solution)) == bits(row[name] for name in NUMBERS), placement
            statuses[row["status"]] += 1
        assert len(rows) == len(measurements.placements(kind))
    assert sum(statuses.values()) == 1000
    assert statuses["ok"] >= 500, statuses
    refused = {"ambiguous", "inconsistent", "degenerate", "not-validated", "too-few-touches", "unknown-surface"}
    assert refused | {"invalid-input"} <= set(statuses), statuses
    print(dict(statuses))


@pytest.mark.parametrize("kind", KINDS)
def test_batch(frames: dict[str, pa.Table], kind: str) -> None:
    """``touchref.batch`` and ``touchref batch``: the same table."""
    fixture = measurements.fixtures()[kind][0]
    found = pa.table(touchref.batch(table(kind), fixture, tip_radius=measurements.TIP_RADIUS, sigma=measurements.SIGMA))
    assert found.schema.equals(frames[kind].schema, check_metadata=True)
    assert found.drop_columns("message").equals(frames[kind].drop_columns("message"))
    # A file is named in messages, with its row group.
    assert [text and re.sub(r"^[^ ]*, row group \d+, ", "", text) for text in frames[kind]["message"].to_pylist()] == found[
        "message"
    ].to_pylist()


def examples() -> list[str]:
    """The measurements that users have."""
    from conftest import ROOT

    found = [path.relative_to(ROOT).as_posix() for path in ROOT.glob("examples/**/*.toml")]
    assert len(found) >= 7
    return sorted(found)


@pytest.mark.parametrize("path", examples())
def test_examples(command: Any, root: Path, path: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """``to_json`` prints what ``locate --format json`` prints; an error has its details."""
    monkeypatch.chdir(root)
    dialects = ["kuka", "matrix", "euler:zyx:intrinsic:deg"]
    asked = [word for name in dialects for word in ("--dialect", name)]
    status, printed = command("locate", path, "--format", "json", *asked)
    try:
        solution = touchref.Measurement.read(path).locate()
    except touchref.TouchrefError as error:
        assert isinstance(error, touchref.Refused if status == 1 else touchref.InputError)
        assert error.details == json.loads(printed)["error"]
    else:
        assert solution.to_json(*dialects) == printed
        assert [solution.frame.dialect(name) for name in dialects] == [
            json.loads(printed)["dialects"][name] for name in dialects
        ]
        page = tmp_path / "page.html"
        solution.report(page, title="One", notes=["Two"], at=[[300, 0, 0]])
        options = ["--title", "One", "--note", "Two", "--at", "300,0,0"]
        _, told = command("report", "-", *options, stdin=solution.to_json())
        assert told == page.read_text(encoding="utf-8")


def test_documents(command: Any, tmp_path: Path) -> None:
    """With the full margin, of arrays: the whole document, of frames and of refusals."""
    told: Counter[int] = Counter()
    for kind in KINDS:
        fixture = measurements.fixtures()[kind][0]
        for placement in measurements.placements(kind)[:12]:
            path = tmp_path / "m.json"
            write_measurement(path, fixture)
            touches = [
                {"surface": label, "at": at, "id": f"t{index}"}
                for index, (label, at) in enumerate(zip(placement.labels, placement.touches))
            ]
            if placement.approaches:
                for touch, approach in zip(touches, placement.approaches):
                    touch["approach"] = approach
            if np.isnan(placement.touches).any():
                continue
            document = {**json.loads(path.read_text()), "touch": touches}
            path.write_text(json.dumps(document), encoding="utf-8")
            status, printed = command("locate", path, "--format", "json")
            told[status] += 1
            try:
                solution = touchref.locate(
                    fixture,
                    placement.touches,
                    placement.labels,
                    tip_radius=measurements.TIP_RADIUS,
                    sigma=measurements.SIGMA,
                    approaches=placement.approaches,
                    ids=[f"t{index}" for index in range(len(touches))],
                )
            except touchref.TouchrefError as error:
                expected = json.loads(printed)["error"]
                # What has no file has no place in it.
                for place in ("file", "line", "column", "offset", "length"):
                    expected.pop(place, None)
                for touch in expected.get("touches", ()):
                    touch["line"] = None
                assert {key: value for key, value in error.details.items() if key != "file"} == expected
            else:
                assert solution.to_json() == printed
    assert told[0] > 20 and told[1] > 3, told
