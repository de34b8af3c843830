#!/usr/bin/env python3
"""Independent maximum-likelihood frames of simulated measurements of the three fixtures.

What
    Seeded measurements of `cylinder-plane`, `three-sphere` and `cube`, and for each the frame that fits it best under
    the known geometry and the stated uncertainties, its covariance, chi-square, residuals and the uncertain
    quantities as the touches moved them, at 60 digits; written to `maximum_likelihood.json`. Shares no code and no
    method with the library, which is held to this file.

Model
    A touch is a tip centre p in the parent. Its residual is d = signed distance of p from its surface less the tip
    radius, positive outside the material; in a bore distance and normal are turned round. The frame minimises
        F = sum (d / sigma)^2 + sum ((q - nominal) / u)^2
    over its six unknowns and every quantity q that is stated with an uncertainty u > 0: sizes of the fixture and the
    tip radius. The geometry depends on them exactly. sigma is the probe's or the touch's own; for a touch with a
    covariance C (parent axes) sigma^2 = n . C n, where n is the surface's outward normal at that touch, in the
    parent: it depends on the frame (and on an uncertain angle), and F with it. The logarithm of sigma that a
    likelihood has besides is not part of F.
    The covariance is the inverse of J^T J at the minimum, J the derivatives of all terms that F squares (of sigma,
    too, and of the priors), its rows and columns of the frame: translation of the origin and rotation vector about
    it, both along parent axes, t' = t + dt, R' = exp(dw) R.

Method
    Everything is written in the parent, on the fixture's axes X, Y, Z as vectors there. Derivatives come from jets
    (numbers that carry their first and second derivatives), no formula for a derivative is written anywhere but those
    of the square root, the reciprocal, sine and cosine. Newton's method with the exact second derivative of F, from
    the simulated truth, in Cayley's chart of the rotation about the current axes,
        v' = v + 2 / (1 + c . c) (c x v + c x (c x v)), where a small c is half the rotation vector.
    Each minimum must have a gradient below 1e-30 in every unknown, a positive definite second derivative, and
    derivatives that central differences of F and of its terms, computed without jets, confirm. The measurements
    solved are the doubles printed in the file, exactly.
    A second method in double precision must land on the same frame to 1e-9 of the fixture's size and on the same
    covariance to 1e-6: Levenberg-Marquardt with complex-step derivatives on fixture coordinates.
    It also starts from 96 random frames, to tell whether a measurement is sound: no other minimum that has the
    touches on the right sides lies below twice the 1e-6 level of chi-square, F is below 0.9 times its 1e-3 level, the
    condition below 500, and the curvature and the rise of F at 7.3 standard deviations along the weakest motion are
    well within the bounds that the docs of touchref-solvers state. Measurements that are not sound are drawn again,
    so these cases are tamer than chance.

Frames and surfaces
    cylinder-plane  origin where the axis meets the plane, Z along the axis, the plane's outward normal at
                    (-sin a, 0, cos a). `cylinder_side` only says where the touches lie: F does not know it.
    three-sphere    origin at the centre of a, X toward b, Z along X x (c - a).
    cube            origin at the corner where +x, +y and +z meet, axes along their outward normals; -x at x = -edge.

Keys of a case
    name            what the case is there for
    fixture, probe  as in a measurement file; an uncertain quantity is {value, u}, u in the unit of the value (degrees
                    for `angle_deg`)
    touches         surface and tip centre; `sigma` or `covariance` where the touch has its own
    ambiguous       a second frame fits: the answer is the minimum nearest `true_frame`
    true_frame      the frame the touches were simulated from; rotation by rows, its columns X, Y, Z
    frame           the answer
    covariance      6 x 6, order x y z rx ry rz
    chi_square      F at the minimum; degrees_of_freedom: touches less 6
    residuals       d of each touch at the minimum, a length
    quantities      the uncertain ones at the minimum and their standard deviation there; degrees for `angle_deg`
    condition       largest over smallest singular value of the information about the frame, rotations scaled by the
                    fixture's size: radius, mean centre distance, edge
    curvature       Frobenius norm of the second derivative of the terms in coordinates in which the covariance of all
                    unknowns is the identity

How to run (needs Python 3.9, mpmath 1.3 and numpy; gmpy2 makes it faster; four minutes on one core)
    python3 maximum_likelihood.py             writes maximum_likelihood.json beside this script
    python3 maximum_likelihood.py --check     solves the touches in the file again and compares every number
"""

import argparse
import itertools
import json
import random
import sys
from collections import Counter
from pathlib import Path

import numpy
from mpmath import mp, mpf

mp.dps = 60
EACH = 56  # cases of each fixture
GRADIENT = mpf(10) ** -30  # what the derivative of F may be at the minimum
DECREMENT = mpf(10) ** -90  # of Newton's method, squared standard deviations: the frame is good to 1e-45 of them
NOTHING = mpf(10) ** -40  # residuals below this are zero: as many touches as unknowns
STEP = mpf(10) ** -16  # of the central differences: truncation 1e-32 of third derivatives, rounding 1e-60 / step^2

# --- vectors -----------------------------------------------------------------------------------------------------


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def add(a, b):
    return [x + y for x, y in zip(a, b)]


def sub(a, b):
    return [x - y for x, y in zip(a, b)]


def times(a, k):
    return [x * k for x in a]


def unit(a):
    return times(a, 1 / mp.sqrt(dot(a, a)))


# --- jets --------------------------------------------------------------------------------------------------------


class Jet:
    """A number with its first and second derivatives in the unknowns."""

    def __init__(self, value, slope, bend):
        self.value, self.slope, self.bend = value, slope, bend

    @staticmethod
    def unknowns(values):
        """The unknowns themselves."""
        count = len(values)
        bend = numpy.full((count, count), mpf(0))
        return [Jet(value, numpy.array([mpf(i == k) for i in range(count)]), bend) for k, value in enumerate(values)]

    def of(self, value, first, second):
        """A function of this number, from its value and its two derivatives."""
        bend = self.bend * first + numpy.outer(self.slope, self.slope) * second
        return Jet(value, self.slope * first, bend)

    def __add__(self, other):
        if isinstance(other, Jet):
            return Jet(self.value + other.value, self.slope + other.slope, self.bend + other.bend)
        return Jet(self.value + other, self.slope, self.bend)

    def __mul__(self, other):
        if not isinstance(other, Jet):
            return Jet(self.value * other, self.slope * other, self.bend * other)
        mixed = numpy.outer(self.slope, other.slope)
        bend = self.bend * other.value + other.bend * self.value + mixed + mixed.T
        return Jet(self.value * other.value, self.slope * other.value + other.slope * self.value, bend)

    def reciprocal(self):
        value = 1 / self.value
        return self.of(value, -(value**2), 2 * value**3)

    def __neg__(self):
        return self * mpf(-1)

    def __sub__(self, other):
        return self + -other

    def __rsub__(self, other):
        return -self + other

    def __truediv__(self, other):
        return self * (other.reciprocal() if isinstance(other, Jet) else 1 / mpf(other))

    def __rtruediv__(self, other):
        return self.reciprocal() * other

    __radd__, __rmul__ = __add__, __mul__


def root(x):
    if not isinstance(x, Jet):
        return mp.sqrt(x)
    value = mp.sqrt(x.value)
    return x.of(value, 1 / (2 * value), -1 / (4 * value**3))


def sine_and_cosine(x):
    if not isinstance(x, Jet):
        return mp.sin(x), mp.cos(x)
    sine, cosine = mp.sin(x.value), mp.cos(x.value)
    return x.of(sine, cosine, -sine), x.of(cosine, -sine, -cosine)


# --- the fixtures, in the parent ---------------------------------------------------------------------------------

AXES = {"x": 0, "y": 1, "z": 2}


def nominal(value):
    """Value and standard uncertainty of a parameter of the file."""
    return (value["value"], value["u"]) if isinstance(value, dict) else (value, 0)


def quantities_of(case):
    """Every number of fixture and tip: name -> (value, u)."""
    found = {}
    for name, value in case["fixture"].items():
        if name == "radii":
            found.update({f"radius of {sphere}": (each, 0) for sphere, each in zip("abc", value)})
        elif not isinstance(value, (str, bool)):
            found[name] = nominal(value)
    found["tip_radius"] = nominal(case["probe"]["tip_radius"])
    return found


def size_of(case):
    found = {name: value for name, (value, _) in quantities_of(case).items()}
    if case["fixture"]["kind"] == "three-sphere":
        return (found["ab"] + found["bc"] + found["ca"]) / 3
    return found["radius" if case["fixture"]["kind"] == "cylinder-plane" else "edge"]


def from_round(radial, radius, inside):
    """Distance and normal of a cylinder or a sphere, from the vector out of its axis or centre."""
    length = root(dot(radial, radial))
    distance, normal = length - radius, times(radial, 1 / length)
    return (-distance, times(normal, -1)) if inside else (distance, normal)


def third_center(ab, bc, ca):
    """Where the centre of c is, in fixture coordinates x and y."""
    x = (ab * ab + ca * ca - bc * bc) / (2 * ab)
    return x, root(ca * ca - x * x)


def seen(fixture, origin, axes, q, surface, p):
    """Signed distance of p from a surface, and the surface's outward normal there."""
    v = sub(p, origin)
    x, y, z = axes
    if surface == "cylinder":
        return from_round(sub(v, times(z, dot(z, v))), q["radius"], fixture["bore"])
    if surface == "plane":
        sine, cosine = sine_and_cosine(q["angle_deg"] * (mp.pi / 180))
        normal = sub(times(z, cosine), times(x, sine))
        return dot(normal, v), normal
    if surface in "abc":
        if surface == "b":
            v = sub(v, times(x, q["ab"]))
        elif surface == "c":
            along, across = third_center(q["ab"], q["bc"], q["ca"])
            v = sub(v, add(times(x, along), times(y, across)))
        return from_round(v, q["radius"] if "radius" in q else q[f"radius of {surface}"], False)
    sign, axis = surface
    normal = axes[AXES[axis]]
    return (dot(normal, v), normal) if sign == "+" else (-dot(normal, v) - q["edge"], times(normal, -1))


# --- the best frame at 60 digits ---------------------------------------------------------------------------------


class State:
    """A frame (origin, axes as vectors in the parent) and the uncertain quantities."""

    def __init__(self, origin, axes, uncertain):
        self.origin, self.axes, self.uncertain = origin, axes, uncertain

    def moved(self, step):
        """By a step of numbers or jets: translation, Cayley's c, then the uncertain quantities."""
        c = step[3:6]
        scale = 2 / (1 + dot(c, c))

        def turned(v):
            once = cross(c, v)
            return add(v, times(add(once, cross(c, once)), scale))

        return State(add(self.origin, step[:3]), [turned(v) for v in self.axes], add(self.uncertain, step[6:]))


class Measurement:
    """What F sees of a case: everything from the printed doubles, nothing from how it was made."""

    def __init__(self, case):
        self.fixture = case["fixture"]
        self.quantities = {name: (mpf(value), mpf(u)) for name, (value, u) in quantities_of(case).items()}
        self.uncertain = [name for name, (_, u) in self.quantities.items() if u > 0]
        self.touches = []
        for touch in case["touches"]:
            at = [mpf(v) for v in touch["at"]]
            covariance = [[mpf(v) for v in row] for row in touch["covariance"]] if "covariance" in touch else None
            own = touch.get("sigma", case["probe"]["sigma"])
            self.touches.append((touch["surface"], at, covariance, mpf(own) if covariance is None else None))

    def values(self, state):
        exact = {name: value for name, (value, _) in self.quantities.items()}
        return {**exact, **dict(zip(self.uncertain, state.uncertain))}

    def residuals(self, state):
        """(residual, outward normal) of each touch."""
        values = self.values(state)
        for surface, at, _, _ in self.touches:
            distance, normal = seen(self.fixture, state.origin, state.axes, values, surface, at)
            yield distance - values["tip_radius"], normal

    def terms(self, state):
        """What F squares and adds."""
        terms = []
        for (residual, normal), (_, _, covariance, sigma) in zip(self.residuals(state), self.touches):
            if covariance is not None:
                sigma = root(dot(normal, [dot(row, normal) for row in covariance]))
            terms.append(residual / sigma)
        for name, value in zip(self.uncertain, state.uncertain):
            middle, u = self.quantities[name]
            terms.append((value - middle) / u)
        return terms

    def jets(self, state):
        """Terms, their first derivatives (rows) and second derivatives."""
        terms = self.terms(state.moved(Jet.unknowns([mpf(0)] * (6 + len(self.uncertain)))))
        return [t.value for t in terms], [t.slope for t in terms], [t.bend for t in terms]

    def minimum(self, state):
        """The minimum of F nearest a state, by Newton's method."""
        for _ in range(40):
            terms, rows, bends = self.jets(state)
            gradient = 2 * sum(row * term for row, term in zip(rows, terms))
            second = 2 * sum(numpy.outer(row, row) + bend * term for row, bend, term in zip(rows, bends, terms))
            second = mp.matrix(second.tolist())
            step = mp.lu_solve(second, mp.matrix((-gradient).tolist()))
            if -dot_all(gradient, step) < DECREMENT:
                assert max(abs(g) for g in gradient) < GRADIENT, "not a stationary point"
                mp.cholesky(second)  # raises where it is not positive definite
                self.confirm(state, terms, rows, gradient, second)
                return state, terms, rows, bends
            state = state.moved(list(step))
        raise ArithmeticError("Newton's method did not settle")

    def confirm(self, state, terms, rows, gradient, second):
        """Derivatives at a minimum against central differences without jets, along every unknown and two others."""
        count = len(gradient)
        directions = [[mpf(i == k) for i in range(count)] for k in range(count)]
        directions += [[mpf((3 * i * i + k * i + 1) % 7 - 3) for i in range(count)] for k in (1, 2)]
        here = dot_all(terms, terms)
        for direction in directions:
            up, down = (self.terms(state.moved(times(direction, sign * STEP))) for sign in (1, -1))
            for a, b, row in zip(up, down, rows):
                slope = dot_all(row, direction)
                assert abs((a - b) / (2 * STEP) - slope) < mpf(10) ** -20 * (1 + abs(slope)), "a wrong derivative"
            up, down = dot_all(up, up), dot_all(down, down)
            # The gradient is zero: what is left are third derivatives, 1e-32 of them.
            assert abs((up - down) / (2 * STEP)) < mpf(10) ** -18, "a wrong gradient"
            bend = dot_all(direction, second * mp.matrix(direction))
            assert abs((up - 2 * here + down) / STEP**2 / bend - 1) < mpf(10) ** -20, "a wrong second derivative"


def dot_all(a, b):
    return sum(x * y for x, y in zip(a, b))


def to_double(x):
    return float(x) if abs(x) > NOTHING else 0.0


def answer(case):
    """Everything the file says about the best frame of a case."""
    measurement = Measurement(case)
    truth = case["true_frame"]
    axes = [[mpf(row[k]) for row in truth["rotation"]] for k in range(3)]
    # The printed truth is rounded: made orthogonal again.
    x = unit(axes[0])
    y = unit(sub(axes[1], times(x, dot(x, axes[1]))))
    start = State([mpf(v) for v in truth["origin"]], [x, y, cross(x, y)], [])
    start.uncertain = [measurement.quantities[name][0] for name in measurement.uncertain]
    state, terms, rows, bends = measurement.minimum(start)

    count = 6 + len(measurement.uncertain)
    information = mp.matrix(sum(numpy.outer(row, row) for row in rows).tolist())
    # Cayley's c is half the rotation vector.
    scale = [1, 1, 1, 2, 2, 2] + [1] * len(measurement.uncertain)
    inverse = information**-1
    covariance = [[inverse[i, j] * scale[i] * scale[j] for j in range(count)] for i in range(count)]
    size = [1, 1, 1] + [mpf(size_of(case))] * 3
    spread = mp.eigsy(mp.matrix([[covariance[i][j] * size[i] * size[j] for j in range(6)] for i in range(6)]), True)
    whitening = mp.cholesky(inverse)
    whitened = (whitening.T * mp.matrix(bend.tolist()) * whitening for bend in bends)
    curvature = mp.sqrt(sum(mp.mnorm(bend, "f") ** 2 for bend in whitened))
    return {
        "frame": {
            "origin": [float(v) for v in state.origin],
            "rotation": [[float(axis[i]) for axis in state.axes] for i in range(3)],
        },
        "covariance": [[float(covariance[i][j]) for j in range(6)] for i in range(6)],
        "chi_square": to_double(dot_all(terms, terms)),
        "degrees_of_freedom": len(measurement.touches) - 6,
        "residuals": [to_double(residual) for residual, _ in measurement.residuals(state)],
        "quantities": [
            {"name": name, "value": float(value), "u": float(mp.sqrt(covariance[6 + k][6 + k]))}
            for k, (name, value) in enumerate(zip(measurement.uncertain, state.uncertain))
        ],
        "condition": float(mp.nstr(mp.sqrt(max(spread) / min(spread)), 4)),
        "curvature": float(mp.nstr(curvature, 4)),
    }


# --- the second method, in double precision on many frames at once -----------------------------------------------

STARTS = 96
SEARCH_STEPS, FINAL_STEPS = 50, 100
TINY = 1e-30  # of the complex steps: its square is nothing beside 1
CONDITION, CURVATURE, RISE, REACH = 500, 0.15, (0.7, 2), 7.3


def level(chance, degrees):
    """The value that chi-square exceeds with this chance."""
    half = mpf(max(degrees, 1)) / 2

    def exceeded(x):
        return mp.log(mp.gammainc(half, x / 2, mp.inf, regularized=True) / chance)

    return float(mp.findroot(exceeded, (2 * half + 10, 2 * half + 40), solver="anderson", tol=1e-12))


class Doubles:
    """A case in double precision, with frames as arrays (..., 3) and (..., 3, 3) and fixture coordinates."""

    def __init__(self, case):
        self.case, self.fixture = case, case["fixture"]
        quantities = quantities_of(case)
        self.exact = {name: value for name, (value, _) in quantities.items()}
        self.uncertain = {name: (value, u) for name, (value, u) in quantities.items() if u > 0}
        self.surfaces = [touch["surface"] for touch in case["touches"]]
        self.at = numpy.array([touch["at"] for touch in case["touches"]])
        own = [touch.get("sigma", case["probe"]["sigma"]) or 1.0 for touch in case["touches"]]
        covariances = [touch.get("covariance", numpy.eye(3) * sigma**2) for touch, sigma in zip(case["touches"], own)]
        self.covariance = numpy.array(covariances, dtype=float)
        self.size = size_of(case)
        self.degrees = len(self.surfaces) - 6
        self.unknowns = 6 + len(self.uncertain)

    def nominal(self, frames):
        values = [value for value, _ in self.uncertain.values()]
        return numpy.tile(numpy.array(values, dtype=float), (frames, 1))

    def contacts(self, origin, rotation, extras):
        """Touches, residuals and outward normals in fixture coordinates."""
        local = numpy.einsum("...ji,...nj->...ni", rotation, self.at - origin[..., None, :])
        q = {**self.exact, **{name: extras[..., k] for k, name in enumerate(self.uncertain)}}
        residuals, normals = [], []
        for k, surface in enumerate(self.surfaces):
            p = local[..., k, :]
            normal = numpy.zeros_like(p)
            if surface in ("cylinder", "a", "b", "c"):
                center = numpy.zeros_like(p)
                if surface == "cylinder":
                    center[..., 2] = p[..., 2]
                elif surface == "b":
                    center[..., 0] = q["ab"]
                elif surface == "c":
                    cosine = (q["ab"] ** 2 + q["ca"] ** 2 - q["bc"] ** 2) / (2 * q["ab"] * q["ca"])
                    center[..., 0] = q["ca"] * cosine
                    center[..., 1] = q["ca"] * numpy.sqrt(1 - cosine**2)  # NaN where a step broke the triangle
                length = numpy.sqrt(((p - center) ** 2).sum(-1))
                side = -1 if self.fixture.get("bore") else 1
                normal = side * (p - center) / length[..., None]
                distance = side * (length - (q["radius"] if "radius" in q else q[f"radius of {surface}"]))
            else:
                if surface == "plane":
                    angle = q["angle_deg"] * (numpy.pi / 180)
                    normal[..., 0], normal[..., 2] = -numpy.sin(angle), numpy.cos(angle)
                else:
                    normal[..., AXES[surface[1]]] = 1 if surface[0] == "+" else -1
                distance = (normal * p).sum(-1) - (q["edge"] if surface[0] == "-" else 0)
            residuals.append(distance - q["tip_radius"])
            normals.append(normal)
        return local, numpy.stack(residuals, -1), numpy.stack(normals, -2)

    def terms(self, origin, rotation, extras):
        _, residuals, normals = self.contacts(origin, rotation, extras)
        normals = numpy.einsum("...ij,...nj->...ni", rotation, normals)
        variances = numpy.einsum("...ni,nij,...nj->...n", normals, self.covariance, normals)
        priors = [(extras[..., k] - value) / u for k, (value, u) in enumerate(self.uncertain.values())]
        return numpy.concatenate([residuals / numpy.sqrt(variances)] + [p[..., None] for p in priors], -1)

    def jacobian(self, origin, rotation, extras):
        """Derivatives by translation and rotation vector along parent axes and by the uncertain quantities."""
        columns = []
        for k in range(self.unknowns):
            t, r, e = (a.astype(complex) for a in (origin, rotation, extras))
            if k < 3:
                t[..., k] += 1j * TINY
            elif k < 6:
                r = r + 1j * TINY * (spin(numpy.eye(3)[k - 3]) @ rotation)
            else:
                e[..., k - 6] += 1j * TINY
            columns.append(self.terms(t, r, e).imag / TINY)
        return numpy.stack(columns, -1)

    @numpy.errstate(invalid="ignore")
    def descend(self, origin, rotation, extras, steps):
        """Levenberg-Marquardt from many frames at once; a step to where F is not defined is no step."""
        damping = numpy.full(len(origin), 1e-3)
        terms = self.terms(origin, rotation, extras)
        squares = (terms**2).sum(-1)
        for _ in range(steps):
            rows = self.jacobian(origin, rotation, extras)
            normal = numpy.einsum("...ni,...nj->...ij", rows, rows)
            gradient = numpy.einsum("...ni,...n->...i", rows, terms)
            diagonal = numpy.einsum("...ii->...i", normal) + 1e-12
            damped = normal + numpy.eye(self.unknowns) * (damping[:, None] * diagonal)[:, None, :]
            step = -numpy.linalg.solve(damped, gradient[..., None])[..., 0]
            step[:, 3:6] *= numpy.minimum(1, 1 / (numpy.linalg.norm(step[:, 3:6], axis=1) + 1e-300))[:, None]
            there = origin + step[:, :3], rodrigues(step[:, 3:6]) @ rotation, extras + step[:, 6:]
            new_terms = self.terms(*there)
            new_squares = (new_terms**2).sum(-1)
            better = new_squares <= squares
            origin, rotation, extras, terms, squares = (
                numpy.where(better.reshape((-1,) + (1,) * (old.ndim - 1)), new, old)
                for old, new in zip((origin, rotation, extras, terms, squares), (*there, new_terms, new_squares))
            )
            damping = numpy.clip(numpy.where(better, damping / 10, damping * 10), 1e-14, 1e10)
        return origin, rotation, extras, squares

    def settle(self, origin, rotation):
        """The minimum nearest one frame, with undamped steps at the end: (origin, rotation, extras)."""
        state = self.descend(origin[None], rotation[None], self.nominal(1), 30)[:3]
        for _ in range(8):
            rows = self.jacobian(*state)[0]
            step = numpy.linalg.lstsq(rows, -self.terms(*state)[0], rcond=None)[0][None]
            origin, rotation, extras = state
            state = origin + step[:, :3], rodrigues(step[:, 3:6]) @ rotation, extras + step[:, 6:]
        return state

    def on_right_sides(self, origin, rotation, extras):
        """Whether the contact points lie, in the mean, on the side of the other surfaces where they must."""
        local, _, normals = (a[0] for a in self.contacts(origin, rotation, extras))
        q = {**self.exact, **dict(zip(self.uncertain, extras[0]))}
        points = local - normals * q["tip_radius"]
        surfaces = numpy.array(self.surfaces)
        if self.fixture["kind"] == "cylinder-plane":
            angle = numpy.radians(q["angle_deg"])
            height = (points[surfaces == "cylinder"] @ [-numpy.sin(angle), 0, numpy.cos(angle)]).mean()
            return height < 0 if self.fixture["cylinder_side"] == "behind" else height > 0
        if self.fixture["kind"] == "cube":
            for face in set(self.surfaces):
                others = points[numpy.array([surface[1] != face[1] for surface in surfaces])]
                mean = others[:, AXES[face[1]]].mean()
                if mean > 0 if face[0] == "+" else mean < -q["edge"]:
                    return False
        return True

    def others(self, best, generator):
        """Lowest F among minima other than the best, with the touches on the right sides; infinite without any."""
        size, middle = self.size, self.at.mean(0)
        turns = generator.normal(size=(STARTS, 4))
        origins = middle + generator.normal(size=(STARTS, 3)) * 1.5 * size
        x, y, z, w = (turns / numpy.linalg.norm(turns, axis=1)[:, None]).T
        rotations = numpy.stack(
            [
                numpy.stack([1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)], -1),
                numpy.stack([2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)], -1),
                numpy.stack([2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)], -1),
            ],
            -2,
        )
        found = self.descend(origins, rotations, self.nominal(STARTS), SEARCH_STEPS)
        bound = 2 * LEVELS[1e-6, self.degrees]
        near = found[3] < 1e4 * bound
        found = self.descend(*(a[near] for a in found[:3]), FINAL_STEPS) if near.any() else found
        lowest = numpy.inf
        for k in range(len(found[3])):
            state = tuple(a[k : k + 1] for a in found[:3])
            turned = numpy.abs(state[1][0] - best[1][0]).max()
            moved = numpy.abs(state[0][0] - best[0][0]).max() / size
            # Frames this near each other are judged by the curvature and the rise.
            if max(turned, moved) > 1e-3 and self.on_right_sides(*state):
                lowest = min(lowest, found[3][k])
        return lowest

    def objection(self, ambiguous, generator):
        """Why the measurement is not sound, or None."""
        truth = self.case["true_frame"]
        best = self.settle(numpy.array(truth["origin"]), numpy.array(truth["rotation"]))
        squares = (self.terms(*best) ** 2).sum()
        if not squares < 0.9 * LEVELS[1e-3, self.degrees]:
            return "inconsistent"
        rows = self.jacobian(*best)[0]
        inverse = numpy.linalg.pinv(rows)
        covariance = inverse @ inverse.T
        scale = numpy.array([1, 1, 1] + [self.size] * 3)
        spread, motions = numpy.linalg.eigh(covariance[:6, :6] * scale * scale[:, None])
        if not spread[-1] < CONDITION**2 * spread[0]:
            return "condition"
        weakest = motions[:, -1] * numpy.sqrt(spread[-1]) / scale
        step = covariance[:, :6] @ numpy.linalg.solve(covariance[:6, :6], weakest) * REACH
        for sign in (1, -1):
            origin, rotation, extras = best
            there = (
                origin + sign * step[None, :3],
                rodrigues(sign * step[None, 3:6]) @ rotation,
                extras + sign * step[6:],
            )
            rise = ((self.terms(*there) ** 2).sum() - squares) / REACH**2
            if not RISE[0] < rise < RISE[1]:
                return "rise"
        if not self.on_right_sides(*best):
            return "side"
        second = self.others(best, generator)
        bound = LEVELS[1e-6, self.degrees]
        if ambiguous:
            return None if second < 0.5 * bound else "not ambiguous"
        return "ambiguous" if second < 2 * bound else None

    def compare(self, answered):
        """How far the second method is from an answer: origin in sizes, radians, covariance."""
        truth = self.case["true_frame"]
        state = self.settle(numpy.array(truth["origin"]), numpy.array(truth["rotation"]))
        inverse = numpy.linalg.pinv(self.jacobian(*state)[0])
        covariance = (inverse @ inverse.T)[:6, :6]
        wanted = numpy.array(answered["covariance"])
        deviations = numpy.sqrt(numpy.diag(wanted))
        return (
            numpy.linalg.norm(state[0][0] - answered["frame"]["origin"]) / self.size,
            numpy.linalg.norm(state[1][0] - answered["frame"]["rotation"]),
            numpy.abs((covariance - wanted) / deviations / deviations[:, None]).max(),
            abs((self.terms(*state) ** 2).sum() - answered["chi_square"]),
        )


LEVELS = {(chance, degrees): level(chance, degrees) for chance in (1e-3, 1e-6) for degrees in range(8)}


def spin(w):
    """Matrices that cross vectors with w (..., 3) from the left."""
    x, y, z = numpy.moveaxis(w, -1, 0)
    nothing = numpy.zeros_like(x)
    return numpy.stack([nothing, -z, y, z, nothing, -x, -y, x, nothing], -1).reshape(w.shape + (3,))


def rodrigues(w):
    """Rotations by rotation vectors (n, 3)."""
    angle = numpy.linalg.norm(w, axis=1)[:, None, None]
    k = spin(w)
    return numpy.eye(3) + numpy.sinc(angle / numpy.pi) * k + 0.5 * numpy.sinc(angle / (2 * numpy.pi)) ** 2 * (k @ k)


# --- measurements ------------------------------------------------------------------------------------------------


class Deck:
    """Deals each of its cards equally often, in random order."""

    def __init__(self, generator, cards):
        self.generator, self.cards, self.left = generator, list(cards), []

    def deal(self):
        if not self.left:
            self.left = self.cards[:]
            self.generator.shuffle(self.left)
        return self.left.pop()


class Maker:
    """Makes measurements. All functions are mpmath's, so that the file is the same on every machine."""

    def __init__(self, seed):
        self.random = random.Random(seed)
        self.search = numpy.random.default_rng(seed)
        self.sigma = self.deck(0.001, 0.002, 0.005, 0.01, 0.02, 0.05)
        self.noise = self.deck("probe", "probe", "own sigmas", "own covariances", "own covariances", "mixed noise")
        self.tip = self.deck(0, 1, 1.5, 2.5)
        self.tip_u = self.deck(0, 0, 0.001, 0.004)
        self.reach = self.deck(50, 300, 1000)
        self.pose = self.deck("any", "any", "any", "along the parent's axes")

    def deck(self, *cards):
        return Deck(self.random, cards)

    def uniform(self, low, high):
        return mpf(low) + (mpf(high) - mpf(low)) * mpf(self.random.random())

    def normal(self):
        return mp.sqrt(-2 * mp.log(1 - mpf(self.random.random()))) * mp.cos(2 * mp.pi * mpf(self.random.random()))

    def axes(self):
        x = unit([self.normal() for _ in range(3)])
        y = unit(cross(x, [self.normal() for _ in range(3)]))
        return [x, y, cross(x, y)]

    def axes_along_the_parent(self):
        order = self.random.sample(range(3), 3)
        x, y = ([mpf((i == k) * self.random.choice((1, -1))) for i in range(3)] for k in order[:2])
        return [x, y, cross(x, y)]

    def draw(self, quantities):
        """What the quantities really are."""
        return {
            name: mpf(value) + mpf(u) * self.normal() if u else mpf(value) for name, (value, u) in quantities.items()
        }

    def noise_of(self, kind, sigma):
        """What a touch says of its own noise, and a displacement drawn from it."""
        if kind == "mixed noise":
            kind = self.random.choice(("probe", "own sigmas", "own covariances"))
        if kind == "own covariances":
            axes = self.axes()
            deviations = [mpf(sigma) * k for k in self.random.sample((0.4, 0.7, 1, 1.6, 2.5), 3)]
            rows = [[mpf(0)] * 3 for _ in range(3)]
            for axis, deviation in zip(axes, deviations):
                for i, j in itertools.product(range(3), repeat=2):
                    rows[i][j] += axis[i] * axis[j] * deviation**2
            rounded = [[float(mp.nstr(rows[max(i, j)][min(i, j)], 6)) for j in range(3)] for i in range(3)]
            parts = [times(axis, deviation * self.normal()) for axis, deviation in zip(axes, deviations)]
            return {"covariance": rounded}, add(add(parts[0], parts[1]), parts[2])
        own = {"sigma": sigma * self.random.choice((0.5, 1, 1.5, 3))} if kind == "own sigmas" else {}
        return own, [mpf(own.get("sigma", sigma)) * self.normal() for _ in range(3)]

    def measure(self, name, fixture, layout, ambiguous=False):
        """A sound measurement; `layout` makes (surface, contact point, outward normal), in fixture coordinates."""
        refused = Counter()
        sigma, noise = self.sigma.deal(), self.noise.deal()
        tip, tip_u = self.tip.deal(), self.tip_u.deal()
        reach, pose = self.reach.deal(), self.pose.deal()
        if tip and tip_u:
            name += ", uncertain tip radius"
        if noise != "probe":
            name += f", {noise}"
        probe = {"tip_radius": {"value": tip, "u": tip_u} if tip and tip_u else tip, "sigma": sigma}
        if noise in ("own sigmas", "own covariances"):
            probe["sigma"] = None
        for _ in range(400):
            case = {"name": name, "fixture": fixture, "probe": probe, "touches": [], "ambiguous": ambiguous}
            true = self.draw(quantities_of(case))
            origin = [self.uniform(-reach, reach) for _ in range(3)]
            axes = self.axes() if pose == "any" else self.axes_along_the_parent()
            for surface, point, normal in layout(true):
                own, error = self.noise_of(noise, sigma)
                point = add(point, times(normal, true["tip_radius"]))
                moved = [dot([axis[i] for axis in axes], point) for i in range(3)]
                at = [float(v) for v in add(add(origin, moved), error)]
                case["touches"].append({"surface": surface, "at": at, **own})
            case["true_frame"] = {
                "origin": [float(v) for v in origin],
                "rotation": [[float(axis[i]) for axis in axes] for i in range(3)],
            }
            reason = Doubles(case).objection(ambiguous, self.search)
            if reason is None:
                case.update(answer(case))
                if case["curvature"] < CURVATURE:
                    return case, refused
                reason = "curvature"
            refused[reason] += 1
        raise ArithmeticError(f"{name}: no sound layout found: {refused}")

    def stated(self, value, u):
        return {"value": value, "u": u} if u else value

    # cylinder-plane

    def on_cylinder_plane(self, fixture, counts, plan):
        """Touches where the plan says, then further ones anywhere. On the cylinder places are (share of a turn, share
        of the length), on the plane (share of a turn, distance from the middle in radii)."""

        def layout(true):
            radius = true["radius"]
            sine, cosine = sine_and_cosine(true["angle_deg"] * mp.pi / 180)
            clear = radius * sine / cosine
            on_cylinder, on_plane = plan()
            on_cylinder += [(self.uniform(0, 1), self.uniform(0, 1)) for _ in range(counts[0] - len(on_cylinder))]
            on_plane += [(self.uniform(0, 1), self.uniform(0.2, 1.5)) for _ in range(counts[1] - len(on_plane))]
            for turn, depth in on_cylinder:
                out = [mp.cos(2 * mp.pi * turn), mp.sin(2 * mp.pi * turn), mpf(0)]
                height = clear + 3 * radius * depth
                if fixture["cylinder_side"] == "behind":
                    # Counted from the far end, so that the same ends are low.
                    height = -clear - 3 * radius * (1 - depth)
                yield "cylinder", add(times(out, radius), [0, 0, height]), times(out, -1 if fixture["bore"] else 1)
            for turn, reach in on_plane:
                along, across = reach * mp.cos(2 * mp.pi * turn), reach * mp.sin(2 * mp.pi * turn)
                yield "plane", times([along * cosine, across, along * sine], radius), [-sine, mpf(0), cosine]

        return layout

    def planned(self):
        """Two touches at each end, a quarter turn apart and opposite between the ends; three about the middle."""

        def stray(reach):
            return self.uniform(-reach, reach)

        ends = [(0.375 + k / mpf(4) + stray(0.04), (0.05, 0.95)[k // 2] + stray(0.05)) for k in range(4)]
        return ends, [(mpf(k) / 3 + stray(0.05), 1.3 + stray(0.2)) for k in range(3)]

    def same_angles_at_both_ends(self):
        return [(0.375 + k % 2 / mpf(4), k // 2) for k in range(4)], [(mpf(k) / 3, 1.4) for k in range(3)]

    def anywhere(self):
        return [], []

    def cylinder_planes(self, count):
        counts = self.deck((4, 3), (4, 3), (4, 3), (5, 3), (4, 5), (5, 4), (6, 4), (8, 4))
        radius, angle = self.deck(20, 25, 12.5, 30, 50, 15.0555), self.deck(45, 30, 60, 45, 20, 70, 40, 55, 39.996)
        uncertain = self.deck("", "", "radius", "angle_deg", "radius angle_deg")
        u_radius, u_angle = self.deck(0.003, 0.01, 0.03), self.deck(0.005, 0.02, 0.05)
        side, bore = self.deck("behind", "front"), self.deck(False, True, False)
        plan = self.deck(self.planned, self.planned, self.anywhere)
        for k in range(count):
            names, (on_cylinder, on_plane) = uncertain.deal(), counts.deal()
            fixture = {
                "kind": "cylinder-plane",
                "radius": self.stated(radius.deal(), u_radius.deal() if "radius" in names else 0),
                "angle_deg": self.stated(angle.deal(), u_angle.deal() if "angle_deg" in names else 0),
                "cylinder_side": side.deal(),
                "bore": bore.deal(),
            }
            name = f"{on_cylinder} + {on_plane}" + (f", uncertain {names.replace(' ', ' and ')}" if names else "")
            if k < 2:
                layout = self.on_cylinder_plane(fixture, (4, 3), self.same_angles_at_both_ends)
                yield self.measure("both ends touched at the same angles: two frames fit", fixture, layout, True)
            else:
                layout = self.on_cylinder_plane(fixture, (on_cylinder, on_plane), plan.deal())
                yield self.measure(name, fixture, layout)

    # three-sphere

    def on_spheres(self, counts, twins):
        """Touches about caps that look up and outward; twins: all at one height, where mirrored spheres fit, too."""

        def layout(true):
            x, y = third_center(true["ab"], true["bc"], true["ca"])
            centers = [[mpf(0)] * 3, [true["ab"], mpf(0), mpf(0)], [x, y, mpf(0)]]
            middle = times(add(add(*centers[:2]), centers[2]), mpf(1) / 3)
            lowest = self.random.choice((0, 0, 0.4, 0.7))  # of the touches about the rim, in radii
            for sphere, center, count in zip("abc", centers, counts):
                radius = true["radius"] if "radius" in true else true[f"radius of {sphere}"]
                outward = unit(sub(center, middle))
                lean = 0 if twins else self.uniform(0.3, 0.9)
                up = add([0, 0, mp.cos(lean)], times(outward, mp.sin(lean)))
                side = cross([0, 0, 1], outward)
                other = cross(up, side)
                start = self.uniform(0, 2 * mp.pi)
                for k in range(count):
                    turn = start + 2 * mp.pi * (mpf(k) / 3 + self.uniform(-0.06, 0.06))
                    # A third about the rim; further ones anywhere.
                    height = (
                        mpf(0.3) if twins else lowest + self.uniform(0, 0.25) if k < 3 else self.uniform(lowest, 1)
                    )
                    rim = mp.sqrt(1 - height**2)
                    flat = add(times(side, mp.cos(turn)), times(other, mp.sin(turn)))
                    out = add(times(up, height), times(flat, rim))
                    yield sphere, add(center, times(out, radius)), out

        return layout

    def three_spheres(self, count):
        counts = self.deck((3, 3, 3), (3, 3, 3), (3, 3, 3), (4, 3, 3), (3, 5, 3), (4, 4, 4))
        radii = self.deck(10, 12.7, 15, 7.5, [10, 12.7, 15], [8, 8, 20])
        sides = self.deck((60, 50, 55), (50, 70.71, 50), (80, 45, 60), (40, 40, 40), (45, 62.5, 70.25))
        uncertain = self.deck("", "radius", "ab", "bc ca", "ab bc ca", "radius ab bc ca")
        u_radius, u_side = self.deck(0.002, 0.005, 0.02), self.deck(0.003, 0.01, 0.03)
        for k in range(count):
            names, radius, touched = uncertain.deal().split(), radii.deal(), counts.deal()
            fixture = {"kind": "three-sphere"}
            if k < 2:
                names, radius, touched = [], 12.7, (3, 3, 3)
            if isinstance(radius, list):
                fixture["radii"] = radius
                names = [name for name in names if name != "radius"]
            else:
                fixture["radius"] = self.stated(radius, u_radius.deal() if "radius" in names else 0)
            for side, length in zip(("ab", "bc", "ca"), sides.deal()):
                fixture[side] = self.stated(length, u_side.deal() if side in names else 0)
            name = " + ".join(map(str, touched)) + (f", uncertain {' and '.join(names)}" if names else "")
            name = "touches at one height: the mirrored spheres fit, too" if k < 2 else name
            yield self.measure(name, fixture, self.on_spheres(touched, k < 2), k < 2)

    # cube

    def on_cube(self, counts):
        """Touches anywhere on the faces, away from the edges."""

        def layout(true):
            edge = true["edge"]
            spread = mpf(self.random.choice((1, 1, 0.5, 0.3)))
            for face, count in counts.items():
                axis, sign = AXES[face[1]], 1 if face[0] == "+" else -1
                normal = [mpf(sign * (k == axis)) for k in range(3)]
                for spot in self.spots(count, spread):
                    point = times([mpf(-1) / 2] * 3, edge)
                    point[axis] = mpf(0) if sign > 0 else -edge
                    point[(axis + 1) % 3] += spot[0] * edge
                    point[(axis + 2) % 3] += spot[1] * edge
                    yield face, point, normal

        return layout

    def spots(self, count, spread):
        """Places on a face, in edges from its middle, within a part of it: two far apart, three not in a line."""
        corner = [self.uniform(-0.42, 0.42 - 0.84 * spread) for _ in range(2)]
        while True:
            spots = [[self.uniform(c, c + 0.84 * spread) for c in corner] for _ in range(count)]
            (a, b), (c, d), (e, f) = (spots + [corner] * 2)[:3]
            if count == 2 and mp.hypot(c - a, d - b) < 0.5 * spread:
                continue
            if count >= 3 and abs((c - a) * (f - b) - (d - b) * (e - a)) < 0.3 * spread**2:
                continue
            return spots

    def cubes(self, count):
        # Counts on three faces that meet, and on the faces opposite these.
        counts = self.deck(
            ((3, 2, 1), (0, 0, 0)), ((3, 2, 1), (0, 0, 0)), ((3, 3, 3), (0, 0, 0)), ((3, 3, 3), (0, 0, 0)),
            ((3, 2, 2), (0, 0, 0)), ((4, 4, 4), (0, 0, 0)), ((3, 2, 1), (1, 0, 0)), ((3, 2, 1), (0, 0, 2)),
            ((3, 3, 3), (1, 1, 1)), ((3, 2, 2), (3, 1, 1)), ((2, 2, 3), (0, 2, 0)),
        )  # fmt: skip
        edges, corners = self.deck(30, 40, 50, 25.4), self.deck(*itertools.product("+-", repeat=3))
        order, uncertain, u_edge = (
            self.deck(*itertools.permutations(range(3))),
            self.deck(True, False),
            self.deck(0.002, 0.01, 0.04),
        )
        for _ in range(count):
            (near, far), turn, corner = counts.deal(), order.deal(), corners.deal()
            touched = {}
            for k, axis in enumerate("xyz"):
                sign = corner[k]
                touched[sign + axis] = near[turn[k]]
                if far[turn[k]]:
                    touched["-+"[sign == "-"] + axis] = far[turn[k]]
            is_uncertain = uncertain.deal()
            fixture = {"kind": "cube", "edge": self.stated(edges.deal(), u_edge.deal() if is_uncertain else 0)}
            name = ", ".join(f"{count} on {face}" for face, count in touched.items())
            name += ", uncertain edge" if is_uncertain else ""
            yield self.measure(name, fixture, self.on_cube(touched))


def all_cases(seed, count):
    maker = Maker(seed)
    return itertools.chain(maker.cylinder_planes(count), maker.three_spheres(count), maker.cubes(count))


# --- the file ----------------------------------------------------------------------------------------------------


def write(cases, path, seed):
    """One case a line, every number with the digits (at most 17) that give back the double."""
    about = (
        "Maximum-likelihood frames of simulated measurements, with their covariances, solved at 60 digits from the "
        "doubles printed here. Keys, conventions and method: maximum_likelihood.py."
    )
    text = (
        "{\n"
        + f'"about": {json.dumps(about)},\n'
        + f'"digits": {mp.dps}, "seed": {seed},\n'
        + '"covariance_order": ["x", "y", "z", "rx", "ry", "rz"],\n'
        + '"cases": [\n'
        + ",\n".join(json.dumps(case) for case in cases)
        + "\n]\n}\n"
    )
    path.write_text(text, encoding="utf-8")


def numbers(value, where=""):
    if isinstance(value, dict):
        for key, inner in value.items():
            yield from numbers(inner, f"{where}.{key}")
    elif isinstance(value, list):
        for index, inner in enumerate(value):
            yield from numbers(inner, f"{where}[{index}]")
    else:
        yield where, value


def check(path):
    """Solves every case of the file again, from its touches alone."""
    cases = json.loads(path.read_text(encoding="utf-8"))["cases"]
    for index, case in enumerate(cases):
        for where, got in numbers(answer(case)):
            want = dict(numbers(case))[where]
            if got != want and not abs(got - want) <= 1e-15 * abs(want):
                sys.exit(f"case {index} ({case['name']}){where}: {got!r}, in the file {want!r}")
    print(f"{len(cases)} cases solved again: all numbers as in the file")


def summary(cases):
    """What the file holds, and how far the second method is from it."""
    worst = [0.0] * 4
    squared = []
    for case in cases:
        differences = Doubles(case).compare(case)
        assert all(d < bound for d, bound in zip(differences, (1e-9, 1e-9, 1e-6, 1e-6))), (case["name"], differences)
        worst = [max(a, float(b)) for a, b in zip(worst, differences)]
        # The true frame in the stated covariance: chi-square with six degrees of freedom.
        true, got = case["true_frame"], case["frame"]
        turn = numpy.array(true["rotation"]) @ numpy.array(got["rotation"]).T
        turned = [(turn[2, 1] - turn[1, 2]) / 2, (turn[0, 2] - turn[2, 0]) / 2, (turn[1, 0] - turn[0, 1]) / 2]
        error = numpy.concatenate([numpy.subtract(true["origin"], got["origin"]), turned])
        squared.append(error @ numpy.linalg.solve(numpy.array(case["covariance"]), error))
    kinds = Counter(case["fixture"]["kind"] for case in cases)
    condition, curvature = (max(case[key] for case in cases) for key in ("condition", "curvature"))
    return f"""cases: {dict(kinds)}
second method off by at most: origin {worst[0]:.1e} sizes, {worst[1]:.1e} rad, covariance {worst[2]:.1e}, \
chi-square {worst[3]:.1e}
squared error of the true frame: mean {numpy.mean(squared):.2f} (6 +- {(12 / len(squared)) ** 0.5:.2f} expected), \
largest {max(squared):.1f}
condition up to {condition}, curvature up to {curvature}"""


def main():
    here = Path(__file__).resolve().parent
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "--file", type=Path, default=here / "maximum_likelihood.json", help="the file to write or check"
    )
    parser.add_argument("--seed", type=int, default=20261, help="of the measurements (default: %(default)s)")
    parser.add_argument("--each", type=int, default=EACH, help="measurements of each fixture (default: %(default)s)")
    parser.add_argument("--check", action="store_true", help="solve the touches in the file again and compare")
    arguments = parser.parse_args()
    if arguments.check:
        check(arguments.file)
        return
    cases, refused = [], Counter()
    for index, (case, drawn_again) in enumerate(all_cases(arguments.seed, arguments.each)):
        cases.append(case)
        refused += drawn_again
        again = f" after {dict(drawn_again)}" if drawn_again else ""
        kind = case["fixture"]["kind"]
        figures = f"chi-square {case['chi_square']:.3g}, condition {case['condition']}, curvature {case['curvature']}"
        print(f"{index:4} {kind}: {case['name']}: {figures}{again}", file=sys.stderr)
    write(cases, arguments.file, arguments.seed)
    print(summary(cases), f"drawn again: {dict(refused)}", sep="\n", file=sys.stderr)


if __name__ == "__main__":
    main()
