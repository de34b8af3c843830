"""From touches to the frame."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Sequence
from typing import Any, Optional, Union

import numpy as np
from numpy.typing import ArrayLike

from . import _touchref
from ._arrays import numbers, texts
from ._errors import invalid
from ._plugins import Fixture, Solver, Uncertain, fixture_of_document
from ._results import Frame, Probe, Solution

Near = Union[Frame, Solution, ArrayLike]
"""A frame: one that was found, a homogeneous 4x4 matrix, or ``[x, y, z, qx, qy, qz, qw]``."""


class Measurement:
    """What was measured: a fixture, the touches on it, and the probe; lengths in ``units``.

    ``touches`` are the centres of the tip in the parent, an array (n, 3); ``labels`` name the surface of each. With the
    solver ``robust`` a label may be ``"?"``. ``sigma`` is the standard deviation of one touch along the surface's normal:
    one number, or one a touch. ``approaches`` are the directions in which the probe moved, an array (n, 3); a row of NaN
    where that is not known. ``ids`` are what the touches are called.

    >>> import touchref
    >>> fixture = touchref.Cube(edge=50)
    >>> touchref.Measurement(fixture, [[50, 20, 30]], ["+y", "+x"])
    Traceback (most recent call last):
    touchref.InputError: there are 1 touches, but 2 labels; expected one a touch [invalid-input]
    """

    def __init__(
        self,
        fixture: Fixture,
        touches: ArrayLike,
        labels: Iterable[str],
        *,
        tip_radius: Union[float, Uncertain] = 0.0,
        sigma: Optional[ArrayLike] = None,
        approaches: Optional[ArrayLike] = None,
        ids: Optional[Sequence[str]] = None,
        units: str = "mm",
    ) -> None:
        at = numbers(touches, "touches", (None, 3), "tip centres, an array (n, 3)")
        count = len(at)
        of_touches, of_probe = _sigma(sigma, count)
        given = zip(
            texts(labels, "labels", count, "names of surfaces"),
            map(tuple, at.tolist()),
            of_touches,
            _approaches(approaches, count),
            [None] * count if ids is None else texts(ids, "ids", count, "names of touches"),
        )
        self._native = prototype(fixture, tip_radius, of_probe, units, list(given))

    @classmethod
    def read(cls, path: Union[str, os.PathLike[str]]) -> Measurement:
        """Reads a measurement file: TOML, or the same keys as JSON."""
        return cls._of(_touchref.Measurement.read(os.fspath(path)))

    @classmethod
    def from_toml(
        cls, text: str, *, name: str = "the text", folder: Union[str, os.PathLike[str]] = ""
    ) -> Measurement:
        """The measurement of the text of a measurement file, which messages call ``name``.

        Tables that it names are looked for in ``folder``.
        """
        return cls._of(_touchref.Measurement.from_text(text, name, os.fspath(folder)))

    @classmethod
    def _of(cls, native: _touchref.Measurement) -> Measurement:
        measurement = cls.__new__(cls)
        measurement._native = native
        return measurement

    @property
    def fixture(self) -> Fixture:
        """The fixture."""
        return fixture_of_document(json.loads(self._native.fixture()[0]))

    @property
    def probe(self) -> Probe:
        """The probe as stated."""
        return Probe(**json.loads(self._native.probe()))

    @property
    def units(self) -> str:
        """Unit of every length."""
        return self._native.units()

    def locate(self, *, solver: Union[None, str, Solver] = None, near: Optional[Near] = None) -> Solution:
        """The fixture's frame, as ``touchref locate`` finds it; ``near`` decides between frames that fit equally well.

        Raises :class:`touchref.Refused` where there is no frame to trust, and :class:`touchref.InputError` where the input
        is wrong. May be interrupted; other threads of Python run meanwhile.
        """
        return Solution(self._native.locate(*of_solver(solver), of_near(near)))

    def __repr__(self) -> str:
        return f"Measurement({self.fixture!r}, units={self.units!r})"


def locate(
    fixture: Fixture,
    touches: ArrayLike,
    labels: Iterable[str],
    *,
    tip_radius: Union[float, Uncertain] = 0.0,
    sigma: Optional[ArrayLike] = None,
    approaches: Optional[ArrayLike] = None,
    ids: Optional[Sequence[str]] = None,
    units: str = "mm",
    solver: Union[None, str, Solver] = None,
    near: Optional[Near] = None,
) -> Solution:
    """The fixture's frame from touches on it: see :class:`touchref.Measurement` and its ``locate``.

    >>> import touchref
    >>> cube = touchref.Cube(edge=50)
    >>> touches = [[50, 10, 10], [50, 40, 10], [50, 10, 40], [10, 50, 10], [10, 50, 40], [10, 10, 50]]
    >>> solution = touchref.locate(cube, touches, ["+x", "+x", "+x", "+y", "+y", "+z"], sigma=0.01)
    >>> solution.frame.origin.round(6).tolist(), solution.degrees_of_freedom
    ([50.0, 50.0, 50.0], 0)
    """
    measurement = Measurement(
        fixture,
        touches,
        labels,
        tip_radius=tip_radius,
        sigma=sigma,
        approaches=approaches,
        ids=ids,
        units=units,
    )
    return measurement.locate(solver=solver, near=near)


def prototype(
    fixture: Fixture,
    tip_radius: Union[float, Uncertain],
    sigma: Optional[float],
    units: str,
    touches: Optional[list[Any]],
) -> _touchref.Measurement:
    """The native measurement."""
    if not isinstance(fixture, Fixture):
        raise invalid(f"the fixture is {fixture!r}", "fixture", "make one by touchref.fixture(kind, ...)")
    tip = tip_radius if isinstance(tip_radius, Uncertain) else Uncertain(tip_radius, 0.0)
    stated = (
        float(numbers(tip.value, "tip_radius", (), "a length, 0 or more")),
        float(numbers(tip.u, "tip_radius.u", (), "a length, 0 or more")),
    )
    return _touchref.Measurement.of(fixture.kind, fixture.parameters, units, stated, sigma, touches)


def of_solver(solver: Union[None, str, Solver]) -> tuple[Optional[str], dict[str, Any]]:
    """Name and parameters of a solver."""
    if isinstance(solver, Solver):
        return solver.name, solver.parameters
    if solver is None or isinstance(solver, str):
        return solver, {}
    raise invalid(f"the solver is {solver!r}", "solver", "give a name, or make one by touchref.solver(name, ...)")


def of_near(near: Optional[Near]) -> Optional[list[float]]:
    """The numbers of a frame."""
    if near is None:
        return None
    frame = near.frame if isinstance(near, Solution) else near
    if isinstance(frame, Frame):
        return [*frame.origin.tolist(), *frame.quaternion.tolist()]
    array = np.asarray(frame)
    shape = (4, 4) if array.ndim == 2 else (7,)
    expected = "a frame: a 4x4 matrix or [x, y, z, qx, qy, qz, qw]"
    flat: list[float] = numbers(frame, "near", shape, expected).ravel().tolist()
    return flat


def _sigma(sigma: Optional[ArrayLike], count: int) -> tuple[list[Optional[float]], Optional[float]]:
    """What touches state, and what the probe does."""
    none: list[Optional[float]] = [None] * count
    if sigma is None:
        return none, None
    if np.ndim(sigma) == 0:
        return none, float(numbers(sigma, "sigma", (), "a length > 0"))
    of_touches = numbers(sigma, "sigma", (count,), f"a length > 0, or {count} of them, one a touch")
    return of_touches.tolist(), None


def _approaches(approaches: Optional[ArrayLike], count: int) -> list[Optional[tuple[float, ...]]]:
    if approaches is None:
        return [None] * count
    rows = numbers(approaches, "approaches", (count, 3), f"directions, an array ({count}, 3), one a touch")
    return [None if np.isnan(row).all() else tuple(row.tolist()) for row in rows]
