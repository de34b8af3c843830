"""Fixtures and solvers by name."""

from __future__ import annotations

import json
from copy import deepcopy
from typing import Any, NamedTuple, Optional

from . import _touchref


class Uncertain(NamedTuple):
    """A number with its standard uncertainty.

    >>> import touchref
    >>> touchref.CylinderPlane(radius=touchref.Uncertain(15.0, 0.002), angle_deg=45)
    CylinderPlane(radius=Uncertain(value=15.0, u=0.002), angle_deg=45.0, cylinder_side='behind', bore=False)
    """

    value: float
    u: float


class _Named:
    """What has a name in the registry, and parameters."""

    def __init__(self, name: str, given: dict[str, Any]) -> None:
        self._name = name
        # What is `None` is not given.
        self._given = {key: value for key, value in given.items() if value is not None}

    def _key(self) -> tuple[str, str]:
        return (self._name, json.dumps(self._told(), sort_keys=True, default=list))

    def _told(self) -> dict[str, Any]:
        return self._given

    def __eq__(self, other: object) -> bool:
        return isinstance(other, type(self)) and self._key() == other._key()

    def __hash__(self) -> int:
        return hash(self._key())

    def __repr__(self) -> str:
        cls = type(self)
        named = [repr(self._name)] if cls in (Fixture, Solver) else []
        told = named + [f"{name}={value!r}" for name, value in self._told().items()]
        return f"{cls.__name__}({', '.join(told)})"


class Fixture(_Named):
    """A fixture: named surfaces placed rigidly in one frame; immutable, checked when it is made.

    ``touchref.fixture(kind, ...)`` makes one of any kind that is linked in; most kinds have a class of their own, as
    :class:`touchref.CylinderPlane`, with their parameters in its signature.
    """

    def __init__(self, kind: str, /, **parameters: Any) -> None:
        super().__init__(kind, parameters)
        native = _touchref.Measurement.of(kind, self._given, "mm", (0.0, 0.0), None, None)
        document, surfaces = native.fixture()
        self._parameters: dict[str, Any] = _parameters(json.loads(document)["parameters"])
        self._surfaces = tuple(surfaces)

    @property
    def kind(self) -> str:
        """The name of its plugin."""
        return self._name

    @property
    def parameters(self) -> dict[str, Any]:
        """Its parameters, defaults filled in; numbers that are uncertain are :class:`Uncertain`."""
        return deepcopy(self._parameters)

    @property
    def surfaces(self) -> tuple[str, ...]:
        """The names of its surfaces: what touches are labelled with."""
        return self._surfaces

    def _told(self) -> dict[str, Any]:
        return self._parameters

    def __reduce__(self) -> tuple[Any, tuple[str, dict[str, Any]]]:
        return (_fixture, (self.kind, self._parameters))


class Solver(_Named):
    """A solver and its parameters; immutable, checked when it is made."""

    def __init__(self, name: str, /, **parameters: Any) -> None:
        super().__init__(name, parameters)
        _touchref.check_solver(name, self._given)

    @property
    def name(self) -> str:
        """The name of its plugin."""
        return self._name

    @property
    def parameters(self) -> dict[str, Any]:
        """Its parameters, as far as they are given."""
        return deepcopy(self._given)

    def __reduce__(self) -> tuple[Any, tuple[str, dict[str, Any]]]:
        return (_solver, (self.name, self._given))


CLASSES: dict[tuple[type[_Named], str], type[Any]] = {}
"""The class of each plugin that has one, by its base and the plugin's name."""


def fixture(kind: str, /, **parameters: Any) -> Fixture:
    """A fixture of this kind; ``touchref.FIXTURES`` has their names.

    >>> import touchref
    >>> touchref.fixture("cube", edge=50).surfaces
    ('+x', '-x', '+y', '-y', '+z', '-z')
    """
    cls: Optional[type[Any]] = CLASSES.get((Fixture, kind))
    made: Fixture = cls(**parameters) if cls else Fixture(kind, **parameters)
    return made


def solver(name: str, /, **parameters: Any) -> Solver:
    """A solver of this name; ``touchref.SOLVERS`` has their names.

    >>> import touchref
    >>> touchref.solver("robust", bad="2")
    Robust(bad='2')
    """
    cls: Optional[type[Any]] = CLASSES.get((Solver, name))
    made: Solver = cls(**parameters) if cls else Solver(name, **parameters)
    return made


def _fixture(kind: str, parameters: dict[str, Any]) -> Fixture:
    return fixture(kind, **parameters)


def _solver(name: str, parameters: dict[str, Any]) -> Solver:
    return solver(name, **parameters)


def _parameters(document: dict[str, Any]) -> dict[str, Any]:
    """Parameters out of a JSON document."""

    def value(found: Any) -> Any:
        if isinstance(found, dict):
            return Uncertain(**found) if found.keys() == {"value", "u"} else _parameters(found)
        return [value(one) for one in found] if isinstance(found, list) else found

    return {name: value(found) for name, found in document.items()}


def fixture_of_document(document: dict[str, Any]) -> Fixture:
    """The fixture that a JSON document states."""
    return fixture(document["kind"], **_parameters(document["parameters"]))
