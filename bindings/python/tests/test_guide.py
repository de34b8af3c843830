"""docs/python.md and the Python of README.md: the code runs, and prints what they say."""

from __future__ import annotations

import ast
import contextlib
import io
import os
import re
from pathlib import Path

import pytest

CELL = re.compile(r"```python\n(.*?)```\n(?:\n```text\n(.*?)```\n)?", re.DOTALL)


def printed(code: str, names: dict[str, object]) -> str:
    """What a notebook shows of a cell: what it prints, and the value of an expression at its end."""
    body = ast.parse(code).body
    final = body[-1]
    last = ast.Expression(final.value) if isinstance(final, ast.Expr) else None
    if last:
        body.pop()
    with contextlib.redirect_stdout(io.StringIO()) as output:
        exec(compile(ast.Module(body, []), "<cell>", "exec"), names)
        value = eval(compile(last, "<cell>", "eval"), names) if last else None
        if value is not None:
            print(repr(value))
    return output.getvalue()


@pytest.mark.parametrize("path, fewest", [("docs/python.md", 10), ("README.md", 1)])
def test_the_code_prints_what_the_text_says(
    root: Path, path: str, fewest: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    cells = CELL.findall((root / path).read_text(encoding="utf-8"))
    assert len(cells) >= fewest
    # What it writes goes elsewhere.
    os.symlink(root / "examples", tmp_path / "examples")
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {"__name__": "__main__"}
    for code, quoted in cells:
        real = printed(code, names)
        if os.environ.get("SHOW"):
            print(code, real, sep="---\n")
        assert [line.rstrip() for line in real.splitlines()] == [line.rstrip() for line in quoted.splitlines()], code
