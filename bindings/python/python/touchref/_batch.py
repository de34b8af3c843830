"""Many placements of one fixture, from Arrow to Arrow."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any, Optional, Protocol, Union

from . import _touchref
from ._arrays import numbers
from ._measurement import Measurement, Near, of_near, of_solver, prototype
from ._errors import invalid
from ._plugins import Fixture, Solver, Uncertain


class ArrowStream(Protocol):
    """What has record batches: a table of pyarrow, polars, pandas 3, DuckDB, ... or what reads one."""

    def __arrow_c_stream__(self, requested_schema: Optional[object] = None) -> object:
        """Arrow's C stream in a capsule."""


def batch(
    touches: ArrowStream,
    fixture: Union[Fixture, Measurement],
    *,
    tip_radius: Union[float, Uncertain] = 0.0,
    sigma: Optional[float] = None,
    units: str = "mm",
    solver: Union[None, str, Solver] = None,
    near: Optional[Near] = None,
    fast: bool = False,
    threads: Optional[int] = None,
) -> _touchref.Frames:
    """The frames of many placements, as ``touchref batch`` finds them: one row a placement, in the table's order.

    ``touches`` is a table with the columns ``placement``, ``surface``, ``x``, ``y``, ``z``, and where known ``sigma``,
    ``i``, ``j``, ``k`` and ``units``; the rows of a placement stand together. Instead of fixture, probe and units a
    :class:`touchref.Measurement` may be given that states them; its touches are not used.

    What is returned has ``__arrow_c_stream__``: ``pyarrow.table(frames)``, ``polars.DataFrame(frames)`` and
    ``pandas.DataFrame.from_arrow(frames)`` take it without a copy. A placement without a frame is a row with the code of
    its refusal as ``status`` and no numbers.

    ``fast`` locates plain placements many at once, in the vectors of the processor: the same frames to a millionth of their
    standard deviations, not to the bit.
    """
    parts = batches(
        [touches],
        fixture,
        tip_radius=tip_radius,
        sigma=sigma,
        units=units,
        solver=solver,
        near=near,
        fast=fast,
        threads=threads,
    )
    return _touchref.Frames.joined(list(parts))


def batches(
    touches: Iterable[ArrowStream],
    fixture: Union[Fixture, Measurement],
    *,
    tip_radius: Union[float, Uncertain] = 0.0,
    sigma: Optional[float] = None,
    units: str = "mm",
    solver: Union[None, str, Solver] = None,
    near: Optional[Near] = None,
    fast: bool = False,
    threads: Optional[int] = None,
) -> Iterator[_touchref.Frames]:
    """The same for a table that comes in parts, as its frames are found; a placement may begin in one part and end in the
    next. Holds one part in memory at a time: what engines for large tables call.
    """
    if isinstance(fixture, Measurement):
        if (tip_radius, sigma, units) != (0.0, None, "mm"):
            message = "tip_radius, sigma or units are given beside a measurement, which states them"
            raise invalid(message, "fixture", "leave them out, or give the measurement's fixture alone")
        native = fixture._native
    else:
        stated = None if sigma is None else float(numbers(sigma, "sigma", (), "a length > 0"))
        native = prototype(fixture, tip_radius, stated, units, None)
    if threads is not None and (isinstance(threads, bool) or not isinstance(threads, int) or threads < 1):
        raise invalid(f"threads is {threads!r}; expected a number from 1", "threads")
    stream = _touchref.Stream(native, *of_solver(solver), of_near(near), bool(fast), threads or 0)
    return _located(stream, touches)


def _located(stream: _touchref.Stream, touches: Iterable[Any]) -> Iterator[_touchref.Frames]:
    any_part = False
    for part in touches:
        yield stream.add(part)
        any_part = True
    if any_part:
        yield stream.finish()
