"""touchref: from labelled probe touches on a reference fixture to its 6-DoF frame, with its uncertainty.

>>> import touchref
>>> fixture = touchref.CylinderPlane(radius=1.0, angle_deg=45)
>>> touches = [
...     [2.9270, 2.0000, 1.6250], [1.7750, 2.8000, 1.4438], [1.3730, 2.6000, 3.1166], [3.5270, 3.2000, 3.1082],
...     [2.8250, 2.4000, 4.0395], [3.9020, 5.2000, 4.0353], [2.0480, 5.2000, 4.7853],
... ]
>>> labels = ["cylinder"] * 4 + ["plane"] * 3
>>> solution = touchref.locate(fixture, touches, labels, sigma=0.00005)
>>> solution.frame.origin.round(3).tolist()
[2.9, 3.8, 4.225]
>>> solution.covariance.shape
(6, 6)

Where there is no frame to trust, there is none to take by mistake:

>>> touchref.locate(fixture, touches, labels, sigma=0.1)  # doctest: +ELLIPSIS
Traceback (most recent call last):
touchref.Refused: ...
"""

from ._batch import ArrowStream, batch, batches
from ._errors import InputError, Refused, TouchrefError
from ._measurement import Measurement, locate
from ._plugins import Fixture, Solver, Uncertain, fixture, solver
from ._results import (
    Adjustment,
    Frame,
    Iteration,
    LocatedFrame,
    Observability,
    Probe,
    Root,
    SecondMinimum,
    Solution,
    Touch,
    Trust,
    Twist,
    Warning,
)
from ._touchref import Frames
from . import plugins
from .plugins import *  # noqa: F403

__all__ = [
    "Adjustment",
    "ArrowStream",
    "Fixture",
    "Frame",
    "Frames",
    "InputError",
    "Iteration",
    "LocatedFrame",
    "Measurement",
    "Observability",
    "Probe",
    "Refused",
    "Root",
    "SecondMinimum",
    "Solution",
    "Solver",
    "Touch",
    "TouchrefError",
    "Trust",
    "Twist",
    "Uncertain",
    "Warning",
    "batch",
    "batches",
    "fixture",
    "locate",
    "solver",
]
__all__ += plugins.__all__
