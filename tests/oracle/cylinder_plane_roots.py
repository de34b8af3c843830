#!/usr/bin/env python3
"""Independent reference roots of the seven-touch cylinder-plane fixture.

What
    Seeded measurements (four touches of a cylinder, three of a plane) and, for each, every real frame that satisfies
    the equations, to 60 digits; written to `cylinder_plane_roots.json`. Shares no code and no method with the
    library, which is held to this file.

Source
    Nederbragt and Ravani, "Design of a novel fixture for part referencing", equation (1): with p_i = x_i - x_4 and
    n_1 = p_2 x p_3, n_2 = p_3 x p_1, n_3 = p_1 x p_2 the axis direction s satisfies
        s . (n_1 |p_1 x s|^2 + n_2 |p_2 x s|^2 + n_3 |p_3 x s|^2) = 0.

Method
    The plane touches give the outward normal n; its sign is the one that puts the cylinder touches on the `-n` side
    (`behind`) or the `+n` side (`front`). The axis direction runs on the cone
        s(phi) = cos(a) n + sin(a) (cos(phi) u + sin(phi) v).
    With t = tan(phi / 2), (1 + t^2) s is a quadratic in t and equation (1) a polynomial of degree 6 in t, formed by
    polynomial arithmetic. `mpmath.polyroots` gives all six roots; the real ones are kept. The chart's one blind spot
    (t = infinity, phi = pi) is turned away by an irrational angle, and a second chart must give the same roots.
    Each real root must satisfy the equations it came from to 1e-40 (in radii): four equal distances from the axis,
    the angle, the plane. The numbers solved are the doubles printed in the file, exactly.

Frame of a root (axes and origin seen from the parent)
    Z along the axis with n . Z > 0, Y = n x Z normalised, X = Y x Z; the origin is where the axis meets the plane.
    Touches are tip centres: the plane is the one through the three tip centres moved by -tip_radius n, and the
    surface's radius is the distance of the tip centres from the axis less tip_radius (pin) or plus it (bore).

Keys of a case
    name            what the case is there for
    radius .. tip_radius   the fixture and the probe; `radius` is the known one, no equation uses it
    noise           standard deviation of each coordinate of the touches the case was made with; 0: rounding only
    cylinder, plane tip centres in the parent
    roots           every real root, the one with the radius nearest the known one first. `sensitivity`: how fast it
                    moves with the 21 coordinates, as Frobenius norms of the Jacobians, made dimensionless: rotation
                    (radians per touch displacement in radii), origin, radius. Rounding the touches in the last place
                    moves the root by about 1e-16 times the largest coordinate times this: the tolerance to hold
                    a double-precision solver to.
    smallest_gap    smallest angle phi between two real roots (null below two roots)
    nearest_complex smallest |Im phi| of the other roots (null without them): small means a double root just missed
    true_frame      the frame the touches were made from (only where noise is 0), good to rounding
    covariance      only on some cases: of (x, y, z, rx, ry, rz, radius) at the first root, for independent errors of
                    standard deviation 1 of each of the 21 coordinates (multiply by sigma^2). Translation of the
                    origin and rotation vector, both along parent axes: t' = t + dt, R' = exp(dw) R. By central
                    differences of the root, solved again at each of the 42 displaced measurements.

How to run (needs Python 3.9 and mpmath 1.3; gmpy2 makes it faster; about a minute)
    python3 cylinder_plane_roots.py             writes cylinder_plane_roots.json beside this script
    python3 cylinder_plane_roots.py --check     solves the touches in the file again and compares every number
    python3 cylinder_plane_roots.py --judge FILE     whether roots that were found elsewhere are these: a case a line,
                                                     with the axes `real` and `near_misses` (tests/closed_form.rs)
"""

import argparse
import itertools
import json
import random
import sys
from pathlib import Path

from mpmath import mp, mpf

mp.dps = 60
COUNT = 120
COVARIANCES = 30
RESIDUAL = mpf(10) ** -40  # what a root may miss the equations by, in radii
REAL = mpf(10) ** -30  # |Im phi| below which a root is real; the search never lands near it
STEP = mpf(10) ** -20  # of the central differences, in radii
CHARTS = (mp.sqrt(2), mp.sqrt(3) + 2)  # where the two charts start, in radians

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


def norm(a):
    return mp.sqrt(dot(a, a))


def unit(a):
    return times(a, 1 / norm(a))


# --- polynomials in t, as lists of coefficients, lowest first ----------------------------------------------------


def poly_add(a, b):
    size = max(len(a), len(b))
    return [(a[i] if i < len(a) else mpf(0)) + (b[i] if i < len(b) else mpf(0)) for i in range(size)]


def poly_mul(a, b):
    out = [mpf(0)] * (len(a) + len(b) - 1)
    for i, x in enumerate(a):
        for j, y in enumerate(b):
            out[i + j] += x * y
    return out


def poly_dot(a, b):
    """Scalar product of a constant vector and a vector of polynomials."""
    out = [mpf(0)]
    for x, y in zip(a, b):
        out = poly_add(out, [x * c for c in y])
    return out


# --- the fixture -------------------------------------------------------------------------------------------------


class Measurement:
    """What the equations see of one case: everything from the printed doubles, nothing from how it was made."""

    def __init__(self, case):
        self.cylinder = [[mpf(x) for x in p] for p in case["cylinder"]]
        self.plane = [[mpf(x) for x in p] for p in case["plane"]]
        self.angle = mpf(case["angle_deg"]) * mp.pi / 180
        self.radius = mpf(case["radius"])
        self.tip = mpf(case["tip_radius"])
        self.bore = case["bore"]
        self.behind = case["cylinder_side"] == "behind"
        self.prepare()

    def prepare(self):
        a, b, c = self.plane
        n = unit(cross(sub(b, a), sub(c, a)))
        sides = [dot(n, sub(p, a)) for p in self.cylinder]
        assert max(sides) < 0 or min(sides) > 0, "cylinder touches on both sides of the plane"
        if (sides[0] < 0) != self.behind:
            n = times(n, -1)
        self.n = n
        self.p = [sub(x, self.cylinder[3]) for x in self.cylinder[:3]]
        p1, p2, p3 = self.p
        self.normals = [cross(p2, p3), cross(p3, p1), cross(p1, p2)]
        # Any fixed reference gives directions u, v that move smoothly with n.
        least = min(range(3), key=lambda i: abs(n[i]))
        self.e = unit(cross(n, [mpf(i == least) for i in range(3)]))

    def displaced(self, coordinate, step):
        """The same measurement with one of the 21 coordinates displaced."""
        other = object.__new__(Measurement)
        other.__dict__.update(self.__dict__)
        other.cylinder, other.plane = [list(p) for p in self.cylinder], [list(p) for p in self.plane]
        (other.cylinder + other.plane)[coordinate // 3][coordinate % 3] += step
        other.prepare()
        return other

    def chart(self, start):
        """Directions u and v: phi is counted from `start`."""
        f = cross(self.n, self.e)
        c, s = mp.cos(start), mp.sin(start)
        u = add(times(self.e, c), times(f, s))
        return u, cross(self.n, u)

    def direction(self, phi):
        u, v = self.chart(mpf(0))
        around = add(times(u, mp.cos(phi)), times(v, mp.sin(phi)))
        return add(times(self.n, mp.cos(self.angle)), times(around, mp.sin(self.angle)))

    def equation(self, phi):
        """Equation (1) at phi."""
        s = self.direction(phi)
        total = mpf(0)
        for p, normal in zip(self.p, self.normals):
            q = cross(p, s)
            total += dot(s, normal) * dot(q, q)
        return total

    def polynomial(self, start):
        """Equation (1) times (1 + t^2)^3: seven coefficients, lowest first."""
        u, v = self.chart(start)
        ca, sa = mp.cos(self.angle), mp.sin(self.angle)
        s = [[ca * n + sa * a, 2 * sa * b, ca * n - sa * a] for n, a, b in zip(self.n, u, v)]
        total = [mpf(0)]
        for p, normal in zip(self.p, self.normals):
            square = [mpf(0)]
            for i in range(3):
                j, k = (i + 1) % 3, (i + 2) % 3
                q = poly_add([p[j] * c for c in s[k]], [-p[k] * c for c in s[j]])
                square = poly_add(square, poly_mul(q, q))
            total = poly_add(total, poly_mul(poly_dot(normal, s), square))
        assert len(total) == 7
        return total

    def all_phi(self, start):
        """All six roots as complex angles phi."""
        coefficients = self.polynomial(start)
        largest = max(abs(c) for c in coefficients)
        assert abs(coefficients[6]) > largest * mpf(10) ** -12, "a root sits at the chart's blind spot"
        roots = mp.polyroots(
            [c / largest for c in reversed(coefficients)], maxsteps=500, extraprec=2 * mp.prec, error=False
        )
        return [2 * mp.atan(t) + start for t in roots]

    def solve(self):
        """Real roots phi in [0, 2 pi) in ascending order, and the smallest |Im phi| of the others."""
        found = []
        for start in CHARTS:
            every = self.all_phi(start)
            real = sorted(mp.re(phi) % (2 * mp.pi) for phi in every if abs(mp.im(phi)) < REAL)
            rest = sorted(abs(mp.im(phi)) for phi in every if abs(mp.im(phi)) >= REAL)
            found.append((real, rest))
        (real, rest), (again, _) = found
        assert len(real) == len(again) and len(real) % 2 == 0, "the two charts disagree"
        for phi in real:
            assert min(abs(mp.sin((phi - other) / 2)) for other in again) < RESIDUAL, "the two charts disagree"
        return real, (rest[0] if rest else None)

    def frame(self, phi):
        """(origin, X, Y, Z, surface radius) of the root at phi."""
        z = self.direction(phi)
        # Centre c of the circle through the projected touches, from x_4: c . p_i = |p_i x z|^2 / 2 and c . z = 0.
        # Solved in the plane across z with the two best of the three touches.
        y = unit(cross(self.n, z))
        x = cross(y, z)
        flat = [(dot(p, x), dot(p, y)) for p in self.p]
        areas = [(abs(flat[i][0] * flat[j][1] - flat[i][1] * flat[j][0]), i, j) for i, j in ((0, 1), (1, 2), (0, 2))]
        _, i, j = max(areas)
        (a, b), (c, d) = flat[i], flat[j]
        first, second = (a * a + b * b) / 2, (c * c + d * d) / 2
        det = a * d - b * c
        cx, cy = (first * d - b * second) / det, (a * second - first * c) / det
        on_axis = add(self.cylinder[3], add(times(x, cx), times(y, cy)))
        distance = mp.sqrt(cx * cx + cy * cy)
        on_plane = sub(self.plane[0], times(self.n, self.tip))
        origin = add(on_axis, times(z, dot(self.n, sub(on_plane, on_axis)) / dot(self.n, z)))
        return origin, x, y, z, distance + (self.tip if self.bore else -self.tip)

    def residual(self, frame):
        """How far a frame misses the original equations, in radii."""
        origin, x, y, z, radius = frame
        to_axis = radius + (-self.tip if self.bore else self.tip)
        misses = [norm(cross(sub(p, origin), z)) - to_axis for p in self.cylinder]
        misses += [dot(self.n, sub(p, origin)) - self.tip for p in self.plane]
        angles = [dot(self.n, z) - mp.cos(self.angle), dot(self.n, x) + mp.sin(self.angle), dot(self.n, y)]
        angles += [dot(cross(x, y), z) - 1, dot(z, z) - 1]
        return max([abs(m) / self.radius for m in misses] + [abs(m) for m in angles])

    def follow(self, phi, slope):
        """The root near phi, by Newton's method with the slope at the undisplaced root."""
        for _ in range(60):
            change = self.equation(phi) / slope
            phi -= change
            if abs(change) < mpf(10) ** -50:
                return phi
        raise ArithmeticError("Newton's method did not settle")

    def jacobian(self, phi):
        """Derivatives of (origin, rotation vector, radius) with respect to the 21 coordinates: 21 rows of 7."""
        step = STEP * self.radius
        slope = mp.diff(self.equation, phi)
        base = self.frame(phi)
        rows = []
        for coordinate in range(21):
            ends = []
            for sign in (1, -1):
                moved = self.displaced(coordinate, sign * step)
                ends.append(moved.frame(moved.follow(phi, slope)))
            plus, minus = ends
            row = [(a - b) / (2 * step) for a, b in zip(plus[0], minus[0])]
            # d(axis) = dw x axis, so dw = 1/2 sum axis x d(axis).
            turn = [mpf(0)] * 3
            for axis, a, b in zip(base[1:4], plus[1:4], minus[1:4]):
                turn = add(turn, cross(axis, times(sub(a, b), 1 / (2 * step))))
            rows.append(row + times(turn, mpf(1) / 2) + [(plus[4] - minus[4]) / (2 * step)])
        return rows


def frame_keys(frame):
    return {key: [float(c) for c in v] for key, v in zip(("origin", "x_axis", "y_axis", "z_axis"), frame)}


def answer(case, covariance):
    """Everything the file says about the roots of a case."""
    measurement = Measurement(case)
    phis, nearest_complex = measurement.solve()
    gaps = [(b - a) % (2 * mp.pi) for a, b in zip(phis, phis[1:] + phis[:1])] if len(phis) > 1 else []
    solved = [(phi, measurement.frame(phi)) for phi in phis]
    solved.sort(key=lambda root: abs(root[1][4] - measurement.radius))
    roots, matrix = [], None
    for phi, frame in solved:
        miss = measurement.residual(frame)
        assert miss < RESIDUAL, f"{case['name']}: residual {mp.nstr(miss, 3)}"
        rows = measurement.jacobian(phi)
        size = [
            mp.sqrt(sum(c * c for row in rows for c in row[part])) for part in (slice(3), slice(3, 6), slice(6, 7))
        ]
        sensitivity = {"rotation": size[1] * measurement.radius, "origin": size[0], "radius": size[2]}
        roots.append(
            {
                "radius": float(frame[4]),
                **frame_keys(frame),
                "sensitivity": {key: float(mp.nstr(value, 4)) for key, value in sensitivity.items()},
            }
        )
        if covariance and matrix is None:
            matrix = [[float(sum(row[i] * row[j] for row in rows)) for j in range(7)] for i in range(7)]
    result = {
        "roots": roots,
        "smallest_gap": float(mp.nstr(min(gaps), 6)) if gaps else None,
        "nearest_complex": float(mp.nstr(nearest_complex, 6)) if nearest_complex is not None else None,
    }
    if matrix:
        result["covariance"] = matrix
    return result


# --- measurements ------------------------------------------------------------------------------------------------


class Maker:
    """Makes measurements. All functions are mpmath's, so that the file is the same on every machine."""

    def __init__(self, seed):
        self.random = random.Random(seed)

    def uniform(self, low, high):
        return mpf(low) + (mpf(high) - mpf(low)) * mpf(self.random.random())

    def normal(self):
        return mp.sqrt(-2 * mp.log(1 - mpf(self.random.random()))) * mp.cos(2 * mp.pi * mpf(self.random.random()))

    def direction(self):
        return unit([self.normal() for _ in range(3)])

    def frame(self, z, reach):
        """A frame with this Z axis, X turned at random about it, and an origin within `reach`."""
        x = unit(cross(self.direction(), z))
        return [self.uniform(-reach, reach) for _ in range(3)], x, cross(z, x), z

    def layout(self, fixture):
        """Where the touches are: (turn, depth) on the cylinder, (x, y) in units of the radius on the plane."""
        turns = [(self.uniform(0, 2 * mp.pi), self.uniform(0, 1)) for _ in range(4)]
        while True:
            spots = [(self.uniform(-2, 2), self.uniform(-2, 2)) for _ in range(3)]
            (a, b), (c, d), (e, f) = spots
            if abs((c - a) * (f - b) - (d - b) * (e - a)) > 1.5:
                return turns, spots

    def measure(self, fixture, frame, layout, noise=0):
        """Tip centres in the parent for a layout, as doubles."""
        origin, x, y, z = frame
        radius, tip = mpf(fixture["radius"]), mpf(fixture["tip_radius"])
        angle = mpf(fixture["angle_deg"]) * mp.pi / 180
        ca, sa = mp.cos(angle), mp.sin(angle)
        to_axis = radius + (-tip if fixture["bore"] else tip)
        turns, spots = layout
        local = []
        for turn, depth in turns:
            across = to_axis * mp.cos(turn), to_axis * mp.sin(turn)
            # On the plane's own level the generator line meets the plane at height across * tan(angle); stay clear of
            # it by half a radius and two tips, and reach down to three radii beyond its lowest height.
            edge = across[0] * sa / ca
            clear = (radius / 2 + 2 * tip) / ca
            if fixture["cylinder_side"] == "behind":
                height = edge - clear - depth * (edge + to_axis * sa / ca + 3 * radius)
            else:
                height = edge + clear + depth * (to_axis * sa / ca - edge + 3 * radius)
            local.append([across[0], across[1], height])
        n = [-sa, mpf(0), ca]
        e1, e2 = [ca, mpf(0), sa], [mpf(0), mpf(1), mpf(0)]
        for a, b in spots:
            local.append(add(times(n, tip), add(times(e1, a * radius), times(e2, b * radius))))
        points = []
        for p in local:
            there = add(origin, add(times(x, p[0]), add(times(y, p[1]), times(z, p[2]))))
            points.append([float(c + (mpf(noise) * self.normal() if noise else 0)) for c in there])
        return {"cylinder": points[:4], "plane": points[4:]}


def count_roots(case):
    """Quick count of the real roots, and the smallest gap between two of them."""
    with mp.workdps(30):
        every = Measurement(case).all_phi(CHARTS[0])
        real = sorted(mp.re(phi) % (2 * mp.pi) for phi in every if abs(mp.im(phi)) < mpf(10) ** -15)
        gaps = [(b - a) % (2 * mp.pi) for a, b in zip(real, real[1:] + real[:1])] if len(real) > 1 else []
        return len(real), (min(gaps) if gaps else None)


ANGLES = [45, 30, 60, 5, 85, 20, 70, 40, 12.5, 77.5, 50, 35, 65, 8, 82, 25, 55, 15, 75, 39.996]
RADII = [1, 20, 3.5, 12.7, 0.8, 25]


def fixture_of(number, **fixed):
    """Fixture parameters that run through all combinations as the number grows."""
    radius = RADII[number % len(RADII)]
    fixture = {
        "radius": radius,
        "angle_deg": ANGLES[(number * 7) % len(ANGLES)],
        "cylinder_side": ("behind", "front")[number % 2],
        "bore": bool((number // 2) % 2),
        "tip_radius": (0, round(radius * 0.1, 6))[(number // 4) % 2],
    }
    fixture.update(fixed)
    return fixture


def paper_example():
    return {
        "name": "printed example of the paper",
        "radius": 1, "angle_deg": 45, "cylinder_side": "behind", "bore": False, "tip_radius": 0, "noise": 0,
        "cylinder": [
            [2.9270, 2.0000, 1.6250], [1.7750, 2.8000, 1.4438], [1.3730, 2.6000, 3.1166], [3.5270, 3.2000, 3.1082],
        ],
        "plane": [[2.8250, 2.4000, 4.0395], [3.9020, 5.2000, 4.0353], [2.0480, 5.2000, 4.7853]],
        "true_frame": None,
    }  # fmt: skip


def exact_on_coordinate_axis(axis, sign, bore):
    """Radius 5, whole numbers throughout: the true root is exact, its axis along a coordinate axis."""
    # In fixture coordinates the plane is z = x (45 degrees) and the touches are 3-4-5 triples below it.
    local = [[3, 4, -6], [-4, 3, -11], [-5, 0, -20], [4, -3, -15], [2, 7, 2], [-8, -6, -8], [9, -5, 9]]
    z = [0, 0, 0]
    z[axis] = sign
    x = [0, 0, 0]
    x[(axis + 1) % 3] = 1
    y = [z[1] * x[2] - z[2] * x[1], z[2] * x[0] - z[0] * x[2], z[0] * x[1] - z[1] * x[0]]
    origin = [7, -13, 4]
    points = [[float(o + p[0] * a + p[1] * b + p[2] * c) for o, a, b, c in zip(origin, x, y, z)] for p in local]
    name = f"whole numbers, axis along {'+' if sign > 0 else '-'}{'xyz'[axis]}"
    return {
        "name": name,
        "radius": 5, "angle_deg": 45, "cylinder_side": "behind", "bore": bore, "tip_radius": 0, "noise": 0,
        "cylinder": points[:4], "plane": points[4:], "true_frame": frame_keys((origin, x, y, z)),
    }  # fmt: skip


def made(maker, name, fixture, noise=0, z=None, reach=None, wanted=None):
    """A random measurement, with the wanted number of real roots where one is given; None if that is too rare."""
    radius = fixture["radius"]
    for _ in range(300):
        frame = maker.frame(z or maker.direction(), reach or 5 * radius)
        case = {"name": name, **fixture, "noise": noise * radius}
        case.update(maker.measure(fixture, frame, maker.layout(fixture), noise * radius))
        if wanted is None or count_roots(case)[0] == wanted:
            case["true_frame"] = frame_keys(frame) if noise == 0 else None
            return case
    return None


class Slide:
    """Touches that slide along a fixture from one random layout to another; the true frame stays."""

    def __init__(self, maker, fixture):
        self.maker, self.fixture = maker, fixture
        self.frame = maker.frame(maker.direction(), 5 * fixture["radius"])
        self.ends = maker.layout(fixture), maker.layout(fixture)

    def at(self, share):
        layout = [
            [tuple(a + (b - a) * share for a, b in zip(p, q)) for p, q in zip(one, two)]
            for one, two in zip(*self.ends)
        ]
        case = {"name": "", **self.fixture, "noise": 0}
        case.update(self.maker.measure(self.fixture, self.frame, layout))
        return case

    def pair(self, share):
        return true_pair(self.at(share), self.frame)

    def where_another_meets_the_true_root(self, low, high, before, after, gap):
        """Where another root has come within `gap` of the true one, having been on its other side at `low`."""
        if before[0] != after[0] or None in (before[1], after[1]) or before[1] * after[1] > 0:
            return None
        if max(abs(before[1]), abs(after[1])) > 0.3:  # not one that passed through: another became the nearest
            return None
        side = 1 if after[1] > 0 else -1
        for _ in range(60):
            middle = (low + high) / 2
            signed = self.pair(middle)[1]
            if signed is None:
                return None
            low, high = (middle, high) if signed * side < gap else (low, middle)
        return self.at(high)

    def where_two_roots_are_born(self, low, high, before, after, gap):
        """Where two roots are `gap` apart, between a share where they are real and one where they are not."""
        if abs(before[0] - after[0]) != 2:
            return None
        more, fewer = (low, high) if before[0] > after[0] else (high, low)
        many = max(before[0], after[0])
        for _ in range(80):
            middle = (more + fewer) / 2
            count, least = count_roots(self.at(middle))
            more, fewer = (middle, fewer) if count == many and least > gap else (more, middle)
        return self.at(more)


def near_double(maker, fixture, gap, with_true):
    """A layout where two real roots are `gap` apart; the true root is one of them or is not."""
    for _ in range(1000):
        slide = Slide(maker, fixture)
        search = slide.where_another_meets_the_true_root if with_true else slide.where_two_roots_are_born
        shares = [mpf(k) / 24 for k in range(25)]
        states = [slide.pair(share) for share in shares]
        for low, high, before, after in zip(shares, shares[1:], states, states[1:]):
            case = search(low, high, before, after, gap)
            if case is None:
                continue
            least = count_roots(case)[1]
            signed = true_pair(case, slide.frame)[1]
            holds_true = signed is not None and abs(signed) < 2 * gap
            if least is not None and gap / 2 < least < 2 * gap and holds_true == with_true:
                which = "the true root and another" if with_true else "two other roots"
                case["name"] = f"near-double root: {which} {gap:g} rad apart"
                case["true_frame"] = frame_keys(slide.frame)
                return case
    raise ArithmeticError("no near-double layout found")


def true_pair(case, frame):
    """Number of real roots, and the signed angle phi from the true root to the nearest other one."""
    with mp.workdps(30):
        measurement = Measurement(case)
        real = [mp.re(phi) for phi in measurement.all_phi(CHARTS[0]) if abs(mp.im(phi)) < mpf(10) ** -15]
        if len(real) < 2:
            return len(real), None
        u, v = measurement.chart(mpf(0))
        true = mp.atan2(dot(frame[3], v), dot(frame[3], u))
        signed = sorted(((phi - true + mp.pi) % (2 * mp.pi) - mp.pi for phi in real), key=abs)
        return len(real), signed[1]


def all_cases(seed):
    maker = Maker(seed)
    zero = mpf(0)
    yield paper_example()
    for number in range(6):
        yield exact_on_coordinate_axis(number % 3, 1 if number < 3 else -1, number % 2 == 1)
    number = 0

    def following(**fixed):
        nonlocal number
        number += 1
        return fixture_of(number, **fixed)

    for axis, name in ((2, "xy"), (0, "yz"), (1, "zx")):
        for noise in (0, 1e-3):
            turn = maker.uniform(0, 2 * mp.pi)
            z = [zero] * 3
            z[(axis + 1) % 3], z[(axis + 2) % 3] = mp.cos(turn), mp.sin(turn)
            yield made(maker, f"axis parallel to the {name} plane", following(), noise, z)
    for k in range(6):
        fixture = following()
        yield made(maker, "origin 1e4 radii away", fixture, (0, 1e-3)[k % 2], reach=1e4 * fixture["radius"])
    for k in range(8):
        radius, scale = ((0.0127, "1e-3"), (12700, "1e3"))[k % 2]
        fixture = following(radius=radius)
        if fixture["tip_radius"]:
            fixture["tip_radius"] = radius * 0.1
        yield made(maker, f"unit scaled by {scale}", fixture, (0, 1e-3)[k // 4])
    for k in range(10):
        # Angles away from the ends, where the geometry itself is singular.
        fixture = following(angle_deg=(45, 30, 60, 40, 50)[k % 5])
        yield near_double(maker, fixture, (1e-3, 1e-5)[k % 2], k // 2 % 2 == 0)

    def with_roots(name, wanted, noise):
        """Goes on to the next fixture where that number of roots is too rare (six below about 25 degrees)."""
        while True:
            case = made(maker, name, following(), noise, wanted=wanted)
            if case:
                return case

    for _ in range(2):
        yield with_roots("no real root: lifted off by noise", 0, 1e-3)
    for k in range(10):
        yield with_roots("six real roots", 6, (0, 1e-3)[k % 2])
    for k in range(22):
        yield with_roots("two real roots", 2, (0, 1e-3, 1e-3)[k % 3])
    for k in range(24):
        yield with_roots("four real roots", 4, (0, 1e-3, 1e-3)[k % 3])
    for k in itertools.count():
        yield made(maker, "random layout", following(), (0, 1e-3)[k % 2])


# --- the file ----------------------------------------------------------------------------------------------------


def write(cases, path, seed):
    """One case a line, every number with the digits (at most 17) that give back the double."""
    lines = [json.dumps(case) for case in cases]
    about = (
        "Every real root of seven-touch cylinder-plane measurements, solved at 60 digits from the doubles "
        "printed here. Keys, conventions and method: cylinder_plane_roots.py."
    )
    text = (
        "{\n"
        + f'"about": {json.dumps(about)},\n'
        + '"source": "Nederbragt and Ravani, Design of a novel fixture for part referencing, equation (1)",\n'
        + f'"digits": {mp.dps}, "seed": {seed},\n'
        + '"covariance_order": ["x", "y", "z", "rx", "ry", "rz", "radius"],\n'
        + '"cases": [\n'
        + ",\n".join(lines)
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
    worst = 0.0
    for index, case in enumerate(cases):
        expected = {key: case[key] for key in ("roots", "smallest_gap", "nearest_complex")}
        if "covariance" in case:
            expected["covariance"] = case["covariance"]
        got = dict(numbers(answer(case, "covariance" in case)))
        want = dict(numbers(expected))
        if got.keys() != want.keys():
            sys.exit(f"case {index} ({case['name']}): other roots than in the file")
        for key, value in want.items():
            if value is None or got[key] is None:
                if value is not got[key]:
                    sys.exit(f"case {index} ({case['name']}){key}: {got[key]}, in the file {value}")
                continue
            miss = abs(got[key] - value) / max(abs(value), 1e-300) if value != got[key] else 0.0
            worst = max(worst, miss)
            if miss > 1e-15 and abs(got[key] - value) > 1e-30:
                sys.exit(f"case {index} ({case['name']}){key}: {got[key]!r}, in the file {value!r}")
    print(f"{len(cases)} cases solved again: all roots as in the file")


def judge(path):
    """Whether every real root was found, and no other."""
    same, double = 1e-6, 1e-5  # radians; two roots nearer than that may have been taken for a near miss, and it for them
    lines = path.read_text(encoding="utf-8").splitlines()
    for line in lines:
        case = json.loads(line)
        measurement = Measurement(case)
        phis, nearest_complex = measurement.solve()
        near = [norm(sub(measurement.direction(a), measurement.direction(b))) for a, b in itertools.combinations(phis, 2)]
        axes = [measurement.direction(phi) for phi in phis]
        nearly_double = min(near, default=1) < double or (nearest_complex is not None and nearest_complex < double)
        found = case["real"] + (case["near_misses"] if nearly_double else [])
        bound = double if nearly_double else same
        missed = [z for z in axes if all(norm(sub(z, other)) > bound for other in found)]
        more = [z for z in case["real"] if not nearly_double and all(norm(sub(z, other)) > bound for other in axes)]
        if missed or more:
            sys.exit(f"case {case['name']}: {len(missed)} of {len(axes)} real roots missed, {len(more)} found that are none")
    print(f"{len(lines)} cases at {mp.dps} digits: no real root missed, none found that is none")


def main():
    here = Path(__file__).resolve().parent
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "--file", type=Path, default=here / "cylinder_plane_roots.json", help="the file to write or check"
    )
    parser.add_argument("--seed", type=int, default=20260, help="of the measurements (default: %(default)s)")
    parser.add_argument("--count", type=int, default=COUNT, help="how many measurements (default: %(default)s)")
    parser.add_argument("--check", action="store_true", help="solve the touches in the file again and compare")
    parser.add_argument("--judge", type=Path, metavar="FILE", help="judge the roots of the cases in this file")
    arguments = parser.parse_args()
    if arguments.judge:
        judge(arguments.judge)
        return
    if arguments.check:
        check(arguments.file)
        return
    cases, covariances = [], 0
    source = all_cases(arguments.seed)
    for index in range(arguments.count):
        case = next(source)
        with_covariance = (
            case["noise"] > 0 and covariances < COVARIANCES and case["name"] != "no real root: lifted off by noise"
        )
        case.update(answer(case, with_covariance))
        covariances += "covariance" in case
        cases.append(case)
        gap, near = case["smallest_gap"], case["nearest_complex"]
        print(
            f"{index:4} {len(case['roots'])} real roots, gap {gap}, complex {near}: {case['name']}", file=sys.stderr
        )
    write(cases, arguments.file, arguments.seed)


if __name__ == "__main__":
    main()
