"""Results: what `touchref locate` prints as JSON, as objects."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Optional, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _html, _touchref
from ._arrays import frozen, numbers
from ._errors import InputError
from ._plugins import Fixture, fixture_of_document

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Frame:
    """A frame of the fixture in its parent, the frame in which the touches are: ``parent = matrix @ fixture``.

    Compare frames by their arrays; these cannot be changed.
    """

    origin: Array
    """The fixture's origin in the parent."""
    x_axis: Array
    """The fixture's X axis in the parent; a unit vector."""
    y_axis: Array
    """The fixture's Y axis in the parent; a unit vector."""
    z_axis: Array
    """The fixture's Z axis in the parent; a unit vector."""
    quaternion: Array
    """Unit quaternion of the rotation fixture to parent, ``[x, y, z, w]`` with ``w >= 0``."""
    matrix: Array
    """Homogeneous 4x4 matrix that maps fixture coordinates into the parent."""

    def to_parent(self, points: ArrayLike) -> Array:
        """Points in fixture coordinates (n x 3, or one of three numbers) as the parent sees them."""
        fixture = np.asarray(points, dtype=np.float64)
        mapped: Array = fixture @ self.matrix[:3, :3].T + self.origin
        return mapped

    def to_fixture(self, points: ArrayLike) -> Array:
        """Points in the parent (n x 3, or one of three numbers) in fixture coordinates."""
        parent = np.asarray(points, dtype=np.float64)
        mapped: Array = (parent - self.origin) @ self.matrix[:3, :3]
        return mapped

    def __repr__(self) -> str:
        return f"{type(self).__name__}(origin={told(self.origin)}, quaternion={told(self.quaternion)})"


@dataclass(frozen=True, eq=False, repr=False)
class LocatedFrame(Frame):
    """The frame that a measurement gave; it can be told in the words of machines."""

    _native: _touchref.Solution

    def dialect(self, name: str) -> str:
        """The frame as a machine takes it: ``kuka``, ``ur``, ``euler:zyx:intrinsic:deg``; see :data:`touchref.DIALECTS`.

        What is told is read back first: a dialect that would tell another frame raises :class:`touchref.Refused`.
        """
        return self._native.dialect(name)[0]

    def dialect_note(self, name: str) -> dict[str, Any]:
        """What the numbers of :meth:`dialect` are relative to, their units and convention, and what rounding loses."""
        note: dict[str, Any] = json.loads(self._native.dialect(name)[1])
        return note


@dataclass(frozen=True, eq=False)
class Touch:
    """A touch, and how far it is from its surface."""

    index: int
    """Which touch, from 0."""
    surface: str
    """Name of the surface."""
    id: Optional[str]
    """What the user calls it."""
    at: Optional[Array]
    """Centre of the tip, in the parent."""
    sigma: Optional[float]
    """Standard deviation along the surface's normal, where the touch states its own."""
    covariance: Optional[Array]
    """Covariance of the position, where the touch states that instead."""
    approach: Optional[Array]
    """Direction in which the probe moved, where that is stated."""
    residual: Optional[float]
    """Signed distance from the surface less the tip radius."""
    normalized: Optional[float]
    """The same in standard deviations."""
    excluded: bool
    """Whether the frame does not rest on it, as the solver holds it for bad."""
    label_found: bool
    """Whether the measurement left its surface open, and the solver found it."""


@dataclass(frozen=True, eq=False)
class Root:
    """One root, and what became of it."""

    frame: Frame
    """Its frame."""
    measures: dict[str, Optional[float]]
    """The dimensions it implies, by name: lengths, or degrees."""
    measures_u: dict[str, Optional[float]]
    """Their standard uncertainties."""
    misfit: Optional[float]
    """How far it is from the known geometry, in standard deviations."""
    selected: bool
    """Whether it is the one."""
    reason: str
    """Why it is, or why not."""


@dataclass(frozen=True, eq=False)
class SecondMinimum:
    """The next best frame."""

    chi_square: Optional[float]
    """Its squared misfit over the variance."""
    frame: Frame
    """The frame."""


@dataclass(frozen=True, eq=False)
class Trust:
    """The margin within which the frame stands: the standard deviation of one touch lies between two bounds."""

    sigma: Optional[float]
    """As stated."""
    from_sigma: Optional[float]
    """Below this the touches contradict the fixture."""
    up_to_sigma: Optional[float]
    """Above this the frame is not the only one, or its uncertainty is not true; ``None`` where nothing limits it."""
    limited_by: str
    """What gives way above: ``none``, ``ambiguity``, ``curvature``, ``rise`` or ``search``."""
    second_minimum: Optional[SecondMinimum]
    """The next best frame."""
    nonlinearity: Optional[float]
    """Relative curvature."""


@dataclass(frozen=True, eq=False)
class Twist:
    """A small motion of the fixture, along the parent's axes."""

    translation: Array
    """Translation of the point ``about``."""
    rotation: Array
    """Rotation vector about that point, radians."""
    about: Array
    """The point, in the parent."""


@dataclass(frozen=True, eq=False)
class Observability:
    """What the touches see."""

    rank: int
    """How many motions the touches determine."""
    condition: Optional[float]
    """Largest over smallest singular value; ``None`` when infinite."""
    weakest: str
    """The motion that the touches see least, in words."""
    twist: Twist
    """The same in numbers."""


@dataclass(frozen=True)
class Probe:
    """The probe as used."""

    tip_radius: float
    """Radius of the tip; 0 where touches are surface points."""
    tip_radius_u: float
    """Its standard uncertainty."""
    sigma: Optional[float]
    """Standard deviation of one touch along the normal, as stated."""


@dataclass(frozen=True)
class Adjustment:
    """An uncertain quantity that was an unknown beside the frame: a length, or degrees."""

    name: str
    """Name of the fixture's parameter, or ``tip_radius``."""
    nominal: Optional[float]
    """As stated."""
    nominal_u: Optional[float]
    """Standard uncertainty of that; ``None`` where only the touches tell it."""
    value: Optional[float]
    """As estimated."""
    u: Optional[float]
    """Standard uncertainty of that."""
    moved: Optional[float]
    """How far it moved, in standard uncertainties."""


@dataclass(frozen=True)
class Iteration:
    """How the iteration ended."""

    steps: int
    """Steps made."""
    stopped_by: str
    """The criterion that ended it: ``gradient``, ``step`` or ``cost``."""


@dataclass(frozen=True)
class Warning:
    """Something to know although the frame stands."""

    code: str
    """By which programs know it."""
    message: str
    """For people."""


class Solution:
    """A frame that passed its checks, and all that was weighed on the way; lengths in :attr:`units`.

    What :func:`touchref.locate` returns. ``Solution.read`` reads what the command line printed.
    """

    def __init__(self, native: _touchref.Solution) -> None:
        self._native = native

    @classmethod
    def read(cls, path: Union[str, os.PathLike[str]]) -> Solution:
        """Reads a result file: what ``to_json``, or ``touchref locate --format json``, gave."""
        name = os.fspath(path)
        try:
            with open(name, encoding="utf-8") as file:
                return cls.from_json(file.read(), name)
        except (OSError, UnicodeDecodeError) as error:
            details = {"code": "unreadable", "message": f"cannot read {name}: {error}", "file": name}
            raise InputError(details) from error

    @classmethod
    def from_json(cls, text: str, name: str = "the text") -> Solution:
        """The result of the text of a result file, which messages call ``name``."""
        return cls(_touchref.Solution.from_json(text, name))

    def to_json(self, *dialects: str) -> str:
        """The document ``touchref.solution/1``, as the command line prints it, with the frame in these dialects."""
        return self._native.json(list(dialects))

    @cached_property
    def document(self) -> dict[str, Any]:
        """The document ``touchref.solution/1`` as Python's own types."""
        document: dict[str, Any] = json.loads(self.to_json())
        return document

    @cached_property
    def frame(self) -> LocatedFrame:
        """The fixture's frame in the parent."""
        return LocatedFrame(**_arrays_of_frame(self.document["frame"]), _native=self._native)

    @cached_property
    def covariance(self) -> Optional[Array]:
        """6x6 covariance of the frame; ``None`` where no sigma is stated and no redundancy tells it.

        Order ``x y z rx ry rz``: translation of the fixture's origin and rotation vector about it in radians, both along
        the parent's axes.
        """
        found = self.document["covariance"]
        return None if found is None else frozen(found["matrix"])

    @property
    def sigma(self) -> Optional[float]:
        """Standard deviation of one touch that the covariance stands on."""
        found = self.document["covariance"]
        return None if found is None else found["sigma"]

    @property
    def sigma_source(self) -> Optional[str]:
        """Where that came from: ``given`` or ``residuals``."""
        found = self.document["covariance"]
        return None if found is None else found["sigma_source"]

    @cached_property
    def fixture(self) -> Fixture:
        """The fixture."""
        return fixture_of_document(self.document["fixture"])

    @property
    def solver(self) -> str:
        """Name of the solver."""
        return str(self.document["solver"])

    @property
    def units(self) -> str:
        """Unit of every length."""
        return str(self.document["units"])

    @property
    def probe(self) -> Probe:
        """The probe as used."""
        return Probe(**self.document["probe"])

    @property
    def free(self) -> tuple[str, ...]:
        """Motions along and about the frame's own axes that the fixture leaves free."""
        return tuple(self.document.get("free", ()))

    @cached_property
    def touches(self) -> tuple[Touch, ...]:
        """The touches in input order, with their residuals."""
        return tuple(_touch(touch) for touch in self.document["touches"])

    @cached_property
    def residuals(self) -> Array:
        """Of each touch, in input order: signed distance from its surface less the tip radius."""
        return _column(self.document["touches"], "residual")

    @cached_property
    def normalized(self) -> Optional[Array]:
        """The same in standard deviations; ``None`` where no sigma is stated."""
        touches = self.document["touches"]
        stated = any(touch["normalized"] is not None for touch in touches)
        return _column(touches, "normalized") if stated else None

    @property
    def rms(self) -> Optional[float]:
        """Root mean square of the residuals of the touches that are not excluded."""
        return _number(self.document["rms"])

    @property
    def chi_square(self) -> Optional[float]:
        """Squared misfit over the variance."""
        return _number(self.document["chi_square"])

    @property
    def degrees_of_freedom(self) -> int:
        """Touches that are not excluded, less unknowns."""
        return int(self.document["degrees_of_freedom"])

    @property
    def p_value(self) -> Optional[float]:
        """Chance of a larger ``chi_square``."""
        return _number(self.document["p_value"])

    @cached_property
    def roots(self) -> tuple[Root, ...]:
        """Every root, and why all but one are out."""
        return tuple(Root(**{**root, "frame": _frame(root["frame"])}) for root in self.document["roots"])

    @property
    def adjustments(self) -> tuple[Adjustment, ...]:
        """Uncertain dimensions and tip radius that were unknowns beside the frame."""
        return tuple(Adjustment(**adjustment) for adjustment in self.document["adjustments"])

    @property
    def iteration(self) -> Optional[Iteration]:
        """How the iteration ended, where there was one."""
        found = self.document["iteration"]
        return None if found is None else Iteration(found["steps"], found["stopped_by"])

    @cached_property
    def trust(self) -> Trust:
        """The margin within which the frame stands."""
        trust = self.document["trust"]
        second = trust["second_minimum"]
        second = None if second is None else SecondMinimum(second["chi_square"], _frame(second["frame"]))
        return Trust(**{**trust, "second_minimum": second})

    @cached_property
    def observability(self) -> Observability:
        """What the touches see."""
        found = self.document["observability"]
        twist = Twist(**{name: frozen(vector) for name, vector in found["twist"].items()})
        return Observability(**{**found, "twist": twist})

    @property
    def warnings(self) -> tuple[Warning, ...]:
        """What to know although the frame stands."""
        return tuple(Warning(**warning) for warning in self.document["warnings"])

    def report(
        self,
        path: Union[str, os.PathLike[str]],
        *,
        title: Optional[str] = None,
        notes: Sequence[str] = (),
        at: ArrayLike = ((0.0, 0.0, 0.0),),
    ) -> None:
        """Writes the page for the record: one HTML file with verdict, view, charts, budget, dialects and touches.

        ``at`` are the points where the frame is used, in fixture coordinates (n x 3); ``notes`` are words for the record.
        """
        points = numbers(at, "at", (None, 3), "points of use, an array (n, 3)").tolist()
        page = self._native.page(title, list(notes), points)
        with open(path, "w", encoding="utf-8", newline="\n") as file:
            file.write(page)

    def picture(self) -> Optional[str]:
        """The fixture, its frame and the touches as SVG; ``None`` for an older result without the touches' places."""
        return self._native.picture(f"frame of {self.document['fixture']['kind']}")

    def __repr__(self) -> str:
        trust = self.trust
        up_to = "any" if trust.up_to_sigma is None else f"{trust.up_to_sigma:.3g}"
        return (
            f"<Solution: {self.document['fixture']['kind']} at {told(self.frame.origin)} {self.units}, "
            f"{len(self.document['touches'])} touches by {self.solver}, "
            f"stands for sigma {trust.from_sigma or 0.0:.3g} to {up_to}>"
        )

    def _repr_html_(self) -> str:
        return _html.of_solution(self.document, self.picture())

    def __reduce__(self) -> tuple[Any, tuple[str]]:
        return (Solution.from_json, (self.to_json(),))


def told(values: Array) -> str:
    """Numbers for people."""
    return f"[{', '.join(f'{value:.6g}' for value in values)}]"


def _number(found: Any) -> Optional[float]:
    return None if found is None else float(found)


def _column(touches: list[dict[str, Any]], name: str) -> Array:
    return frozen([np.nan if touch[name] is None else touch[name] for touch in touches])


def _arrays_of_frame(document: dict[str, Any]) -> dict[str, Any]:
    arrays = {name: frozen(values) for name, values in document.items()}
    arrays["quaternion"] = arrays.pop("quaternion_xyzw")
    return arrays


def _frame(document: dict[str, Any]) -> Frame:
    return Frame(**_arrays_of_frame(document))


def _touch(document: dict[str, Any]) -> Touch:
    array = {key: frozen(document[key]) if key in document else None for key in ("at", "covariance", "approach")}
    rest = {"sigma": None, "excluded": False, "label_found": False, **document}
    return Touch(**{**rest, **array})
