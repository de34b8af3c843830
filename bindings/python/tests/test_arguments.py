"""What is wrong with arguments is told, with what was expected and the nearest name; nothing panics."""

from __future__ import annotations

import pickle
import random
from pathlib import Path
from typing import Any, Callable

import numpy as np
import pandas as pd
import pyarrow as pa
import pytest
import touchref

CUBE = touchref.Cube(edge=50)
TOUCHES = np.array([[50, 10, 10], [50, 40, 10], [50, 10, 40], [10, 50, 10], [10, 50, 40], [10, 10, 50]], dtype=float)
LABELS = ["+x", "+x", "+x", "+y", "+y", "+z"]


def locate(touches: Any = TOUCHES, labels: Any = LABELS, **arguments: Any) -> touchref.Solution:
    return touchref.locate(CUBE, touches, labels, **{"sigma": 0.01, **arguments})


def with_nan() -> Any:
    touches = TOUCHES.copy()
    touches[3, 1] = np.nan
    return touches


def endless() -> list[Any]:
    """A list that holds itself."""
    table: dict[str, Any] = {}
    table["surface"] = [table]
    return [table]


WRONG: list[tuple[Callable[[], object], str, str]] = [
    (lambda: locate(with_nan()), "invalid-input", "touch 3: a coordinate is NaN; expected a finite number"),
    (lambda: locate(TOUCHES * np.inf), "invalid-input", "touch 0: a coordinate is inf"),
    (lambda: locate(TOUCHES.T), "invalid-input", "touches has shape (3, 6); expected tip centres, an array (n, 3)"),
    (lambda: locate(TOUCHES[0]), "invalid-input", "touches has shape (3,)"),
    (lambda: locate(TOUCHES.astype(str)), "invalid-input", "touches has dtype <U32"),
    (lambda: locate(TOUCHES.astype(complex)), "invalid-input", "touches has dtype complex128"),
    (lambda: locate(TOUCHES > 20), "invalid-input", "touches has dtype bool"),
    (lambda: locate([[1, 2, 3], [1, 2]]), "invalid-input", "touches: "),
    (lambda: locate([[1, 2, None]] * 6), "invalid-input", "touches has dtype object"),
    (lambda: locate(np.ma.masked_greater(TOUCHES, 45)), "invalid-input", "touches is masked in places"),
    (lambda: locate(np.empty((0, 3)), []), "too-few-touches", "there are no touches"),
    (lambda: locate(TOUCHES[:4], LABELS[:4]), "too-few-touches", "too few touches"),
    (lambda: locate(labels=LABELS[:5]), "invalid-input", "there are 6 touches, but 5 labels"),
    (lambda: locate(labels="+x+x+x"), "invalid-input", "labels is '+x+x+x'"),
    (lambda: locate(labels=7), "invalid-input", "labels is 7"),
    (lambda: locate(labels=[1] * 6), "invalid-input", "labels[0] is 1; expected a text"),
    (lambda: locate(labels=[*LABELS[:5], "+w"]), "unknown-surface", "the fixture has no surface `+w`"),
    (lambda: locate(sigma=-1), "invalid-input", "the probe's sigma is -1; expected a length > 0"),
    (lambda: locate(sigma=[0.01] * 5), "invalid-input", "sigma has shape (5,)"),
    (lambda: locate(sigma=[0.01] * 5 + [0.0]), "invalid-input", "touch 5: sigma is 0; expected a length > 0"),
    (lambda: locate(sigma="0.1"), "invalid-input", "sigma has dtype <U3"),
    (lambda: locate(tip_radius=-1), "invalid-input", "the probe's tip radius is -1"),
    (lambda: locate(tip_radius=None), "invalid-input", "tip_radius has dtype object"),
    (lambda: locate(approaches=TOUCHES * 0), "invalid-input", "touch 0: the approach is [0, 0, 0]"),
    (lambda: locate(approaches=TOUCHES[:2]), "invalid-input", "approaches has shape (2, 3)"),
    (lambda: locate(units="mmm"), "unknown-name", "unit `mmm` is not known"),
    (lambda: locate(solver="robus"), "unknown-solver", "solver `robus` is not known"),
    (lambda: locate(solver=7), "invalid-input", "the solver is 7"),
    (lambda: locate(near=[1, 2, 3]), "invalid-input", "near has shape (3,)"),
    (lambda: locate(near=np.zeros((4, 4))), "invalid-input", "are no frame"),
    (lambda: locate(near=np.full((4, 4), np.nan)), "invalid-input", "are no frame"),
    (lambda: locate(near=[0, 0, 0, 0, 0, 0, 0]), "invalid-input", "are no frame"),
    (lambda: touchref.locate("cube", TOUCHES, LABELS), "invalid-input", "the fixture is 'cube'"),  # type: ignore[arg-type]
    (lambda: touchref.fixture("cub"), "unknown-fixture", "fixture `cub` is not known"),
    (lambda: touchref.fixture("cube"), "missing-key", "edge"),
    (lambda: touchref.Cube(edge=-1), "invalid-input", "`edge` is -1"),
    (lambda: touchref.Cube(edge=float("nan")), "invalid-input", "`edge` is NaN"),
    (lambda: touchref.Cube(edge="50"), "invalid-input", "`edge` is a word"),  # type: ignore[arg-type]
    (lambda: touchref.Cube(edge=object()), "invalid-input", "no value of a parameter"),  # type: ignore[arg-type]
    (lambda: touchref.Composite(surface=endless()), "invalid-input", "no value of a parameter"),
    (lambda: touchref.Cube(edgge=50), "unknown-key", "has no parameter `edgge`"),  # type: ignore[call-arg]
    (lambda: touchref.Cube(edge=touchref.Uncertain(50, -1)), "invalid-input", "uncertainty"),
    (lambda: touchref.CylinderPlane(radius=1, angle_deg=90), "invalid-input", "`angle_deg` is 90"),
    (lambda: touchref.Composite(surface=[{"name": "a"}]), "missing-key", "type"),
    (lambda: touchref.Robust(bad="9"), "invalid-input", "`bad` is"),  # type: ignore[arg-type]
    (lambda: touchref.solver("robust", bed=1), "unknown-key", "`bed` is not known"),
    (lambda: touchref.Measurement.read("no-such-file.toml"), "unreadable", "no-such-file.toml"),
    (lambda: touchref.Measurement.from_toml("units = 1"), "invalid-input", "units"),
    (lambda: touchref.Measurement.from_toml('units = "mm"'), "missing-key", "fixture"),
    (lambda: touchref.Solution.read("no-such-file.json"), "unreadable", "no-such-file.json"),
    (lambda: touchref.Solution.from_json("{}"), "invalid-input", "is no result"),
    (lambda: locate().frame.dialect("kuk"), "unknown-dialect", "kuk"),
    (lambda: locate().report("/dev/null", at=[1, 2, 3]), "invalid-input", "at has shape (3,)"),
    (lambda: touchref.batch([[1, 2, 3]], CUBE), "invalid-input", "the touches are a `list`"),  # type: ignore[arg-type]
    (lambda: touchref.batch(pa.table({"x": [1.0]}), CUBE), "missing-column", "column `placement` is missing"),
    (lambda: touchref.batch(pa.table({"x": [1.0]}), CUBE, threads=0), "invalid-input", "threads is 0"),
    (lambda: touchref.batch(pa.table({"x": [1.0]}), CUBE, threads=10**6), "invalid-input", "threads is 1000000"),
]


@pytest.mark.parametrize("call, code, message", WRONG)
def test_what_is_wrong_is_told(call: Callable[[], object], code: str, message: str) -> None:
    with pytest.raises(touchref.InputError) as caught:
        call()
    error = caught.value
    assert error.code == code
    assert message in error.message
    assert isinstance(error, ValueError)
    again = pickle.loads(pickle.dumps(error))
    assert (type(again), str(again)) == (touchref.InputError, str(error))


def test_the_nearest_name_is_told() -> None:
    calls: list[tuple[Callable[[], object], str]] = [
        (lambda: locate(labels=[*LABELS[:5], "+zz"]), "+z"),
        (lambda: touchref.fixture("cub"), "cube"),
        (lambda: touchref.Cube(egde=50), "edge"),  # type: ignore[call-arg]
        (lambda: locate(solver="robus"), "robust"),
        (lambda: locate().frame.dialect("kuk"), "kuka"),
    ]
    for call, nearest in calls:
        with pytest.raises(touchref.InputError) as caught:
            call()
        assert caught.value.details["nearest"] == nearest
        assert nearest in caught.value.help


def test_a_place_in_a_file_is_told(tmp_path: Path) -> None:
    path = tmp_path / "m.toml"
    path.write_text('units = "mm"\n[fixture]\nkind = "cube"\nedge = 50\n[[touch]]\nsurface = "+w"\nat = [1, 2, 3]\n')
    with pytest.raises(touchref.InputError) as caught:
        touchref.Measurement.read(path).locate()
    details = caught.value.details
    assert (details["file"], details["line"], details["column"]) == (str(path), 6, 11)
    assert f"at {path}:6:11" in str(caught.value)


def test_a_refusal_has_what_was_found() -> None:
    touches = TOUCHES.copy()
    with pytest.raises(touchref.Refused) as caught:
        touchref.locate(CUBE, np.vstack([touches, [[51.0, 25, 25]]]), [*LABELS, "+x"], sigma=0.01)
    assert caught.value.code == "inconsistent"
    assert caught.value.details["roots"] and caught.value.details["trust"]["sigma"] == 0.01


def test_arrays_of_any_kind() -> None:
    expected = locate().to_json()
    wide = np.zeros((12, 6))
    wide[::2, ::2] = TOUCHES
    frame = pd.DataFrame(TOUCHES, columns=["x", "y", "z"])
    for same in (
        TOUCHES.tolist(),
        TOUCHES.astype(np.float32),
        TOUCHES.astype(np.int16),
        np.asfortranarray(TOUCHES),
        wide[::2, ::2],
        TOUCHES[::-1][::-1],
        TOUCHES.astype(">f8"),
        frame,
        np.ma.masked_array(TOUCHES),
    ):
        assert locate(same).to_json() == expected
    for labels in (tuple(LABELS), np.array(LABELS), pd.Series(LABELS), pd.Categorical(LABELS), iter(LABELS)):
        assert locate(labels=labels).to_json() == expected


def test_nothing_panics() -> None:
    """Arguments of any kind: an error of touchref, a TypeError, or a solution."""
    draw = random.Random(1)
    odd: list[Any] = [None, 0, -1.5, 1e300, float("nan"), "", "+x", [], [[]], {}, b"x", (1, 2), np.eye(4), TOUCHES[:0]]
    odd += [np.full((6, 3), 1e308), [float("inf")] * 6, [["+x"]], object(), TOUCHES, LABELS, np.zeros((6, 3)), True, 2**70]
    names = ["touches", "labels", "sigma", "tip_radius", "approaches", "ids", "units", "solver", "near"]
    solved = 0
    for _ in range(3000):
        chosen = {name: draw.choice(odd) for name in draw.sample(names, draw.choice([1, 1, 2, 3]))}
        try:
            locate(**chosen)
            solved += 1
        except touchref.TouchrefError as error:
            assert error.code and error.message, chosen
        except (TypeError, OverflowError):
            pass
    assert solved
