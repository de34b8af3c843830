#!/usr/bin/env python3
"""Writes ``plugins.pyi``: the classes that the installed package makes of its plugins, for type checkers and editors.

    python stubs.py            prints it
    python stubs.py FILE       writes it; ``python/touchref/plugins.pyi`` in this repository
"""

import inspect
import json
import sys
from typing import Any

from touchref import Fixture, Solver, _touchref, plugins
from touchref._plugins import CLASSES

HEADER = '''\
# Written by stubs.py of the plugins that are linked in: do not edit.

from collections.abc import Mapping, Sequence
from typing import Any, Literal, Optional, Union

from ._plugins import Fixture, Solver, Uncertain

FIXTURES: tuple[str, ...]
"""The kinds of fixtures that :func:`touchref.fixture` makes."""
SOLVERS: tuple[str, ...]
"""The solvers that :func:`touchref.solver` makes."""
DIALECTS: tuple[str, ...]
"""The dialects that ``frame.dialect`` takes."""
'''

TYPES = {
    "uncertain": "Union[float, Uncertain]",
    "number": "float",
    "numbers": "Sequence[float]",
    "flag": "bool",
    "text": "str",
    "tables": "Sequence[Mapping[str, Any]]",
    "any": "Any",
}


def annotation(parameter: dict[str, Any]) -> str:
    """The type of a parameter."""
    words = f"Literal[{', '.join(repr(word) for word in parameter['words'] or ())}]"
    return {"choice": words, "words": f"Sequence[{words}]"}.get(parameter["kind"]) or TYPES[parameter["kind"]]


def of_class(base: type[Any], plugin: dict[str, Any]) -> str:
    """The class of a plugin."""
    cls = CLASSES[base, plugin["name"]]
    signature = inspect.signature(cls)
    arguments = ["self"]
    for parameter in plugin["parameters"]:
        default = signature.parameters[parameter["name"]].default
        told = annotation(parameter)
        if default is None:
            told = f"Optional[{told}]"
        given = "" if default is inspect.Parameter.empty else f" = {default!r}"
        arguments.append(f"{parameter['name']}: {told}{given}")
    if len(arguments) > 1:
        arguments.insert(1, "*")
    doc = "\n".join(f"    {line}".rstrip() for line in (cls.__doc__ or "").splitlines()).strip()
    joined = "".join(f"        {argument},\n" for argument in arguments)
    method = f"    def __init__(\n{joined}    ) -> None: ..."
    return f'\nclass {cls.__name__}({base.__name__}):\n    """{doc}\n    """\n\n{method}\n'


def text() -> str:
    """The whole file."""
    described = json.loads(_touchref.plugins())
    every: tuple[tuple[type[Any], Any], ...] = ((Fixture, described["fixtures"]), (Solver, described["solvers"]))
    classes = [of_class(base, plugin) for base, kind in every for plugin in kind]
    names = "".join(f"    {name!r},\n" for name in plugins.__all__).replace("'", '"')
    return f"{HEADER}{''.join(classes)}\n__all__ = [\n{names}]\n"


if __name__ == "__main__":
    if len(sys.argv) > 1:
        with open(sys.argv[1], "w", encoding="utf-8", newline="\n") as file:
            file.write(text())
    else:
        sys.stdout.write(text())
