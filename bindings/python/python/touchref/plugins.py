"""A class for each fixture and solver that is linked in, made of what its plugin says of itself.

``plugins.pyi`` says the same to type checkers and editors; ``stubs.py`` of the repository writes it.
"""

from __future__ import annotations

import inspect
import json
import re
from typing import Any

from . import _touchref
from ._plugins import CLASSES, Fixture, Solver

_ALL: dict[str, list[dict[str, Any]]] = json.loads(_touchref.plugins())

FIXTURES: tuple[str, ...] = tuple(plugin["name"] for plugin in _ALL["fixtures"])
SOLVERS: tuple[str, ...] = tuple(plugin["name"] for plugin in _ALL["solvers"])
DIALECTS: tuple[str, ...] = tuple(plugin["name"] for plugin in _ALL["dialects"])


def _class_name(name: str) -> str:
    return "".join(word.capitalize() for word in re.split(r"[-_ ]", name))


def _default(parameter: dict[str, Any]) -> Any:
    """What stands in a signature: ``None`` where others tell what takes its place."""
    text = parameter["default"]
    if parameter["required"]:
        return inspect.Parameter.empty
    if text is None or text.startswith(("instead of ", "by ")) or parameter["kind"] in ("tables", "words"):
        return None
    if parameter["kind"] in ("uncertain", "number"):
        return float(text)
    return text == "true" if parameter["kind"] == "flag" else text


def _doc(plugin: dict[str, Any]) -> str:
    lines = [f"{plugin['summary'][:1].upper()}{plugin['summary'][1:]}.", "", plugin["about"]]
    lines += ["", "Parameters:"] if plugin["parameters"] else []
    lines += [f"    {one['name']}: {one['meaning']}; {one['takes']}" for one in plugin["parameters"]]
    lines += ["", "Surfaces:"] if plugin["surfaces"] else []
    lines += [f"    ``{one['name']}``: {one['meaning']}" for one in plugin["surfaces"]]
    return "\n".join([*lines, "", f"Source: {plugin['reference']}"])


def _class(base: Any, plugin: dict[str, Any]) -> Any:
    # That a parameter is missing or unknown is told by the plugin, with the nearest name.
    def __init__(self: Any, **parameters: Any) -> None:
        base.__init__(self, plugin["name"], **parameters)

    signature = [inspect.Parameter("self", inspect.Parameter.POSITIONAL_OR_KEYWORD)]
    for one in plugin["parameters"]:
        default = _default(one) if base is Fixture else None  # The caller of a solver may have a preset.
        signature.append(inspect.Parameter(one["name"], inspect.Parameter.KEYWORD_ONLY, default=default))
    __init__.__signature__ = inspect.Signature(signature)  # type: ignore[attr-defined]
    name = _class_name(plugin["name"])
    return type(name, (base,), {"__init__": __init__, "__doc__": _doc(plugin), "__module__": __name__})


for _base, _plugins in ((Fixture, _ALL["fixtures"]), (Solver, _ALL["solvers"])):
    for _plugin in _plugins:
        _made = _class(_base, _plugin)
        CLASSES[_base, _plugin["name"]] = _made
        globals()[_made.__name__] = _made

__all__ = ["DIALECTS", "FIXTURES", "SOLVERS", *(made.__name__ for made in CLASSES.values())]
