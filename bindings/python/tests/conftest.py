"""What the tests share: the repository, and the command line that was built of it."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).resolve().parents[3]


@pytest.fixture(scope="session")
def root() -> Path:
    """The repository."""
    return ROOT


@pytest.fixture(scope="session")
def command() -> Any:
    """Runs ``touchref`` as it was built of this repository: returns exit status and standard output."""
    target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    binary = Path(os.environ.get("TOUCHREF", target / "debug" / "touchref"))
    assert binary.exists(), f"{binary} is missing: cargo build -p touchref-cli"

    def run(*arguments: object, stdin: str = "") -> tuple[int, str]:
        done = subprocess.run(
            [binary, *map(str, arguments)], input=stdin, capture_output=True, encoding="utf-8", cwd=ROOT, check=False
        )
        return done.returncode, done.stdout

    return run
