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

class Composite(Fixture):
    """Planes, cylinders, spheres and cones of your own, as data in the measurement file.

    Touches: six or more in all, less one for each motion that is free; spread over the surfaces so that together they hold the fixture still.

    Frame: the one that the surfaces are given in.

    Parameters:
        surface: a surface, [[fixture.surface]]; as many as there are; tables, each with type = "plane" or "cylinder" or "sphere" or "cone"
        free: motions along and about the frame's own axes that no surface fixes and that are not wanted; a list of "x", "y", "z", "rx", "ry", "rz"
        size: a length typical of the fixture; length > 0

    Source: kinematic constraint by surfaces: Whitehead, The Design and Use of Instruments and Accurate Mechanism (1934)
    """

    def __init__(
        self,
        *,
        surface: Sequence[Mapping[str, Any]],
        free: Optional[Sequence[Literal['x', 'y', 'z', 'rx', 'ry', 'rz']]] = None,
        size: Optional[Union[float, Uncertain]] = None,
    ) -> None: ...

class Cube(Fixture):
    """Three mutually adjacent faces of a cube: three touches, two and one, or more.

    Touches: 3, 2 and 1 on three faces that meet in a corner, whichever corner and in whichever order, or more; opposite faces may be touched, too.

    Frame: origin at the corner where `+x`, `+y` and `+z` meet, axes along their outward normals: the cube fills -edge to 0 along each axis.

    Parameters:
        edge: length of the cube's edges; length > 0

    Surfaces:
        ``+x``: the face x = 0, outward normal along +X
        ``-x``: the face x = -edge, outward normal along -X
        ``+y``: the face y = 0, outward normal along +Y
        ``-y``: the face y = -edge, outward normal along -Y
        ``+z``: the face z = 0, outward normal along +Z
        ``-z``: the face z = -edge, outward normal along -Z

    Source: the 3-2-1 principle of locating, as in the datum systems of ISO 5459
    """

    def __init__(
        self,
        *,
        edge: Union[float, Uncertain],
    ) -> None: ...

class CylinderPlane(Fixture):
    """A cylinder (pin or bore) and a plane oblique to its axis: four touches and three.

    Touches: 4 on `cylinder` and 3 on `plane`, or more.

    Frame: origin where the cylinder's axis meets the plane; Z along the axis, on the side of the plane's outward normal n; Y along n x Z; X = Y x Z.

    Parameters:
        radius: radius of the cylinder's surface; length > 0
        angle_deg: angle between the cylinder's axis and the plane's normal; 45 is best conditioned; angle in degrees, 0 < value < 90
        cylinder_side: where the cylinder is, seen against the plane's outward normal: behind (an oblique face cut on its end) or in front (it stands out of a plate); "behind" or "front"
        bore: true: the cylinder is touched from inside, as a hole is; true or false

    Surfaces:
        ``cylinder``: the cylinder, about the frame's Z axis
        ``plane``: the oblique plane, through the frame's origin, outward normal (-sin a, 0, cos a)

    Source: B. Nederbragt and B. Ravani, Design of a novel fixture for part referencing, equation (1)
    """

    def __init__(
        self,
        *,
        radius: Union[float, Uncertain],
        angle_deg: Union[float, Uncertain] = 45.0,
        cylinder_side: Literal['behind', 'front'] = 'behind',
        bore: bool = False,
    ) -> None: ...

class ThreeSphere(Fixture):
    """Three balls, or spherical buttons, on a plate: three touches on each.

    Touches: 3 on each of `a`, `b` and `c`, or more.

    Frame: origin at the centre of `a`; X toward the centre of `b`; Z along X x (c - a), toward the probe where `a`, `b`, `c` run counterclockwise; Y = Z x X.

    Parameters:
        radius: radius of all three balls; length > 0
        radii: radii of `a`, `b` and `c` where they differ; taken as exact; [length, length, length], each > 0
        ab: distance between the centres of `a` and `b`; length > 0
        bc: distance between the centres of `b` and `c`; length > 0
        ca: distance between the centres of `c` and `a`; length > 0

    Surfaces:
        ``a``: the ball about the frame's origin
        ``b``: the ball on the positive X axis
        ``c``: the third ball, in the XY plane on the side of positive Y

    Source: each centre by the intersection of three spheres (trilateration); see the documentation of touchref-fixtures, three_sphere
    """

    def __init__(
        self,
        *,
        radius: Optional[Union[float, Uncertain]] = None,
        radii: Optional[Sequence[float]] = None,
        ab: Union[float, Uncertain],
        bc: Union[float, Uncertain],
        ca: Union[float, Uncertain],
    ) -> None: ...

class ClosedForm(Solver):
    """Every root of the fixture's equations; the known dimensions choose.

    Solves the fixture's equations without a starting guess and lists every real root with the dimensions it implies. The known dimensions choose: a root stands when it fits within the stated noise, no other does, and first-order uncertainty holds. The frame rests on the touches alone; take `least-squares` for the frame that the known dimensions make more certain.

    Parameters:
        margin: how far beyond the stated sigma other frames are looked for: near (a tenth, or farther where that is cheap to prove) or full (as far as the frame stands); "near" or "full"

    Source: roots: the fixture's own reference; acceptance: chi-square levels, see docs of touchref-solvers
    """

    def __init__(
        self,
        *,
        margin: Optional[Literal['near', 'full']] = None,
    ) -> None: ...

class Global(Solver):
    """Every minimum of the misfit, with no closed form and no guess: certifies the other solvers.

    The frame of `least-squares`, but from starts that cover all frames instead of what the fixture knows: slow (tens of milliseconds), and as good for a fixture without a closed form. Lists every distinct minimum of the squared misfit, how far it is from the best and how much worse. Take it to certify another solver's answer, or to see what else the touches could mean.

    Source: Alexa, Super-Fibonacci Spirals (2022); acceptance: see docs of touchref-solvers
    """

    def __init__(
        self,
    ) -> None: ...

class LeastSquares(Solver):
    """Maximum likelihood over the frame with known geometry, every candidate refined (default).

    Minimises the squared misfit of all touches over the frame, each weighted by its sigma; dimensions and tip radius with a stated uncertainty are unknowns, too, held by what is known of them. Starts from every root and near miss of the fixture's equations and from a search of what lies between; accepts the best minimum when it fits, no other does, and first-order uncertainty holds. Levenberg-Marquardt on the manifold of frames, run by argmin.

    Parameters:
        margin: how far beyond the stated sigma other frames are looked for: near (a tenth, or farther where that is cheap to prove) or full (as far as the frame stands); "near" or "full"

    Source: Marquardt (1963); right increments as in Sola et al. (2018); acceptance: see docs of touchref-solvers
    """

    def __init__(
        self,
        *,
        margin: Optional[Literal['near', 'full']] = None,
    ) -> None: ...

class Robust(Solver):
    """Least-squares that names a bad touch and leaves it out, or says which touches may be bad.

    Solves as `least-squares` does; where the touches contradict the fixture, tries every hypothesis that one touch is bad (or two, with `bad=2`). The only set of touches without which a frame fits is named and left out, with a warning; where several may be it, the refusal lists them. Says, too, which labels would make the touches fit, and finds the surface of a touch whose file leaves it open (`?`). Wants a sigma. Nine touches (5 + 4, 3 + 3 + 3) are the fewest that can tell any one bad touch.

    Parameters:
        bad: how many touches may be bad at once: a touch is left out only when nothing else explains the contradiction, be it so many bad ones; "1" or "2" or "3"
        margin: how far beyond the stated sigma other frames are looked for: near (a tenth, or farther where that is cheap to prove) or full (as far as the frame stands); "near" or "full"

    Source: Baarda, A testing procedure for use in geodetic networks (1968); acceptance: see docs of touchref-solvers
    """

    def __init__(
        self,
        *,
        bad: Optional[Literal['1', '2', '3']] = None,
        margin: Optional[Literal['near', 'full']] = None,
    ) -> None: ...

__all__ = [
    "DIALECTS",
    "FIXTURES",
    "SOLVERS",
    "Composite",
    "Cube",
    "CylinderPlane",
    "ThreeSphere",
    "ClosedForm",
    "Global",
    "LeastSquares",
    "Robust",
]
