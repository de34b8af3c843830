#!/usr/bin/env python3
"""Makes layouts.json: layouts of touches that leave a motion free, nearly do, or do not, one a line.

What each layout leaves free is computed here with 60 digits (mpmath), from the geometry of the fixtures alone: a touch
resists a motion by the normal it meets, so its row is [n, (p - o) x n / size] for a translation of the fixture's origin o
and a rotation about it times the fixture's size, along the parent's axes. Whether a second frame fits a layout that
determines one is looked for by descents from all over in double precision, each end settled with 60 digits. No code is shared
with touchref.

    python3 layouts.py > layouts.json        needs mpmath and numpy; takes two minutes

Keys of the file:
    sigma       of every touch, mm
    fixtures    `measured`: what a measurement file says of it; its size; its surfaces in fixture coordinates
    layouts     see below
Keys of a layout:
    name        fixture, family and how near, as `cylinder-plane/ring/1e-6/1`
    fixture     index into the fixtures
    touches     surface and place, without error but for rounding to a twentieth of sigma
    frame       the frame they were made at: x, y, z, then the rotation matrix row by row
    condition   largest over smallest singular value of the rows; null where the smallest is zero
    free        orthonormal basis of the motions whose singular value is below the largest over 1e8, [v, w size]; left out
                where there is none
    second      of a condition below 1e4: the other frame that fits best and that the fixture's rule of where touches lie
                allows, and its misfit, the root of the sum of squares in sigmas; left out above 1000
"""

import json
import random

import mpmath as mp
import numpy

mp.mp.dps = 60
SEED = 20261125
# Beyond this condition a motion counts as free.
FREE = mp.mpf("1e8")
# A singular value below this part of the largest is zero in exact arithmetic.
ZERO = mp.mpf("1e-40")
# How far a degenerate layout is disturbed, in parts of the fixture's size or radians; 0 is not at all.
DISTURBED = [0] + [mp.mpf(10) ** -k for k in range(1, 14)]

# Below this condition a layout determines the frame.
SOUND = mp.mpf("1e4")
# Of a touch, mm: above the rounding of touches a metre away, and so little that a second frame fits by no chance.
SIGMA = 1e-10
# A second frame of this misfit, in standard deviations, is told: far more than any level, so that what lies between is
# known to be near it.
DOUBTFUL = 1e3
# Descents in search of it, and steps of each.
STARTS = 256
STEPS = 100

random.seed(SEED)


def vector(*values):
    return mp.matrix([mp.mpf(value) for value in values])


def dot(a, b):
    return sum(a[i] * b[i] for i in range(3))


def cross(a, b):
    return vector(a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def unit(a):
    return a / mp.sqrt(dot(a, a))


def gauss():
    return mp.mpf(random.gauss(0, 1))


# Surfaces: `at` tells, from two coordinates of a place, the point and the outward normal there; `exactly` the signed
# distance of a point and the normal toward it; `many` the same of an array of points in double precision. All in fixture
# coordinates.


class Cylinder:
    """About the z axis."""

    def __init__(self, radius):
        self.radius = mp.mpf(radius)

    def at(self, turn, height):
        normal = vector(mp.cos(turn), mp.sin(turn), 0)
        return normal * self.radius + vector(0, 0, height * self.radius), normal

    def exactly(self, point):
        distance = mp.sqrt(point[0] ** 2 + point[1] ** 2)
        return distance - self.radius, vector(point[0], point[1], 0) / distance

    def many(self, points):
        across = points * [1, 1, 0]
        distances = numpy.linalg.norm(across, axis=1)
        return distances - float(self.radius), across / distances[:, None]

    def told(self):
        return {"cylinder": float(self.radius)}


class Plane:
    def __init__(self, point, normal, size):
        """Places in parts of `size`."""
        self.point, self.normal, self.size = point, unit(normal), mp.mpf(size)
        self.aside = unit(cross(self.normal, vector(0, 0, 1) if abs(self.normal[2]) < 0.9 else vector(1, 0, 0)))

    def at(self, a, b):
        other = cross(self.normal, self.aside)
        return self.point + (self.aside * a + other * b) * self.size, self.normal

    def exactly(self, point):
        return dot(self.normal, point - self.point), self.normal

    def many(self, points):
        point, normal = (numpy.array([float(x) for x in v]) for v in (self.point, self.normal))
        return (points - point) @ normal, numpy.broadcast_to(normal, points.shape)

    def told(self):
        return {"plane": [[float(x) for x in self.point], [float(x) for x in self.normal]]}


class Sphere:
    def __init__(self, center, radius):
        self.center, self.radius = center, mp.mpf(radius)

    def at(self, turn, up):
        """By longitude and latitude."""
        normal = vector(mp.cos(up) * mp.cos(turn), mp.cos(up) * mp.sin(turn), mp.sin(up))
        return self.center + normal * self.radius, normal

    def exactly(self, point):
        away = point - self.center
        return mp.norm(away) - self.radius, unit(away)

    def many(self, points):
        away = points - numpy.array([float(x) for x in self.center])
        distances = numpy.linalg.norm(away, axis=1)
        return distances - float(self.radius), away / distances[:, None]

    def told(self):
        return {"sphere": [[float(x) for x in self.center], float(self.radius)]}


class Face(Plane):
    """A face `+axis` of a cube whose corner is the origin and which lies behind it; places in parts of the edge."""

    def __init__(self, axis, edge):
        self.axis = axis
        super().__init__(vector(0, 0, 0), vector(*(1 if k == axis else 0 for k in range(3))), edge)

    def at(self, a, b):
        point = vector(0, 0, 0)
        point[(self.axis + 1) % 3], point[(self.axis + 2) % 3] = -a * self.size, -b * self.size
        return point, self.normal


def rad(degrees):
    return mp.mpf(degrees) * mp.pi / 180


def places(surface, *coordinates):
    return [(surface, mp.mpf(a), mp.mpf(b)) for a, b in coordinates]


def around(surface, *coordinates):
    """The first coordinate in degrees."""
    return [(surface, rad(a), mp.mpf(b)) for a, b in coordinates]


def on_ball(surface, *coordinates):
    """Both coordinates in degrees."""
    return [(surface, rad(a), rad(b)) for a, b in coordinates]


# Part of its size by which a fixture's surface may be touched beyond its end.
EDGE = mp.mpf("0.02")


class Fixture:
    def __init__(self, kind, parameters, size, surfaces, may_stand, disturbance=1):
        self.kind, self.parameters, self.size, self.surfaces = kind, parameters, mp.mpf(size), surfaces
        # Whether the fixture's documented rule of where touches lie allows them at these places.
        self.may_stand = may_stand
        # Of the coordinates of a place, for a disturbance of one.
        self.disturbance = mp.mpf(disturbance)

    def told(self):
        surfaces = {name: surface.told() for name, surface in self.surfaces.items()}
        measured = {"kind": self.kind, **self.parameters}
        return {"measured": measured, "size": float(self.size), "surfaces": surfaces}


def cylinder_plane(radius, angle):
    normal = vector(-mp.sin(rad(angle)), 0, mp.cos(rad(angle)))
    surfaces = {"cylinder": Cylinder(radius), "plane": Plane(vector(0, 0, 0), normal, radius)}

    def behind(names, points):
        """The mean of the cylinder's touches lies behind the plane."""
        return sum(dot(normal, point) for name, point in zip(names, points) if name == "cylinder") <= 0

    return Fixture("cylinder-plane", {"radius": radius, "angle_deg": angle}, radius, surfaces, behind)


def three_sphere(radius, ab, bc, ca):
    """`a` at the origin, `b` on the x axis, `c` on the side of positive y."""
    x = mp.mpf(ab * ab + ca * ca - bc * bc) / (2 * ab)
    centers = [vector(0, 0, 0), vector(ab, 0, 0), vector(x, mp.sqrt(ca * ca - x * x), 0)]
    surfaces = {name: Sphere(center, radius) for name, center in zip("abc", centers)}
    parameters = {"radius": radius, "ab": ab, "bc": bc, "ca": ca}
    return Fixture("three-sphere", parameters, mp.mpf(ab + bc + ca) / 3, surfaces, lambda *_: True), centers


def cube(edge):
    surfaces = {f"+{name}": Face(axis, edge) for axis, name in enumerate("xyz")}

    def on_their_faces(names, points):
        slack = EDGE * edge
        return all(
            -edge - slack <= point[k] <= slack
            for name, point in zip(names, points)
            for k in range(3)
            if k != surfaces[name].axis
        )

    # Places are parts of the edge, and faces end.
    return Fixture("cube", {"edge": edge}, edge, surfaces, on_their_faces, 0.1)


def block():
    """Three planes of a block that are not perpendicular."""
    planes = {
        "base": (vector(0, 0, 0), vector(0, 0, 1)),
        "fence": (vector(0, -30, 10), vector(0, 3, 1)),
        "stop": (vector(-40, 0, 10), vector(4, 1, 0)),
    }
    number = lambda values: [float(value) for value in values]
    within = 40.0
    tables = [
        {"name": name, "type": "plane", "point": number(point), "normal": number(normal), "within": within}
        for name, (point, normal) in planes.items()
    ]
    # What the composite takes for its size: the largest of distances of the points from their middle and of extents.
    size = mp.mpf(within)
    surfaces = {name: Plane(point, normal, size) for name, (point, normal) in planes.items()}

    def within_their_ends(names, points):
        def off(name, point):
            away = point - surfaces[name].point
            return mp.norm(away - surfaces[name].normal * dot(surfaces[name].normal, away))

        return all(off(name, point) <= size * (1 + EDGE) for name, point in zip(names, points))

    return Fixture("composite", {"surface": tables}, size, surfaces, within_their_ends, 0.1)


# Families: what a layout touches where. Those that leave a motion free do so exactly.

SOUND_CYLINDER = around("cylinder", (135, -4), (225, -4), (315, -1.5), (45, -1.5))
SOUND_PLANE = places("plane", (1.5, 0), (-0.75, 1.3), (-0.75, -1.3))


def families_of_cylinder_plane():
    yield "ring", around("cylinder", (10, -3), (95, -3), (190, -3), (285, -3)) + SOUND_PLANE
    yield "ring-of-eight", around("cylinder", *[(45 * k + 7 * (k % 3), -2.5) for k in range(8)]) + SOUND_PLANE
    yield "one-generator", around("cylinder", (50, -4), (50, -3.2), (50, -2.1), (50, -1.5)) + SOUND_PLANE
    yield "two-opposed-generators", around("cylinder", (20, -4), (200, -3.8), (20, -1.5), (200, -1.2)) + SOUND_PLANE
    opposed = around("cylinder", (20, -4), (200, -4), (80, -1.5), (260, -1.5))
    yield "opposed-pairs", opposed + SOUND_PLANE
    yield "cross", around("cylinder", (10, -4), (100, -1.5), (190, -4), (280, -1.5)) + SOUND_PLANE
    yield "plane-in-a-line", SOUND_CYLINDER + places("plane", (-1, -0.6), (0.25, 0.15), (1, 0.6))
    yield "plane-coincident", SOUND_CYLINDER + places("plane", (1.5, 0), (-0.75, 1.3), (1.5, 0))
    yield "cylinder-coincident", SOUND_CYLINDER[:3] + SOUND_CYLINDER[1:2] + SOUND_PLANE
    yield "one-point", around("cylinder", *[(50, -3)] * 4) + places("plane", *[(0.5, 0.5)] * 3)


def random_cylinder_plane(cylinders, planes):
    turns = [random.uniform(-180, 180) for _ in range(cylinders)]
    on_cylinder = [(turn, random.uniform(-4, -1.2)) for turn in turns]
    on_plane = []
    while len(on_plane) < planes:
        a, b = random.uniform(-1.4, 1.4), random.uniform(-1.4, 1.4)
        if a * a + b * b < 1.96:
            on_plane.append((a, b))
    return around("cylinder", *on_cylinder) + places("plane", *on_plane)


def families_of_three_sphere(centers):
    good = [(0, 35), (120, 35), (240, 35)]
    yield "tops", [place for name in "abc" for place in on_ball(name, *[(0, 90)] * 3)]
    equator = [(90, 0), (210, 0), (330, 0)]
    yield "equators", [place for name in "abc" for place in on_ball(name, *equator)]
    # Normals in the plane of the centres do not see the third ball turn about the line of the other two.
    yield "third-at-its-equator", on_ball("a", *good) + on_ball("b", *good) + on_ball("c", *equator)
    # Every normal meets the vertical through one point.
    middle = sum(centers, vector(0, 0, 0)) / 3
    radial = []
    for name, center in zip("abc", centers):
        inward = mp.atan2(middle[1] - center[1], middle[0] - center[0]) * 180 / mp.pi
        radial += on_ball(name, (inward, 20), (inward, 60), (inward + 180, 40))
    yield "about-the-middle", radial
    about_b = []
    for name, center in zip("abc", centers):
        away = mp.atan2(center[1], center[0] - centers[1][0]) * 180 / mp.pi if name != "b" else mp.mpf(30)
        about_b += on_ball(name, (away, 20), (away, 60), (away + 180, 40))
    yield "about-a-ball", about_b


def random_three_sphere(counts):
    layout = []
    for name, count in zip("abc", counts):
        spots = [(random.uniform(-180, 180), mp.asin(random.uniform(0.05, 1)) * 180 / mp.pi) for _ in range(count)]
        layout += on_ball(name, *spots)
    return layout


def families_of_cube():
    first = places("+x", (0.2, 0.2), (0.8, 0.3), (0.5, 0.8))
    yield "second-face-along-the-first-normal", first + places("+y", (0.4, 0.2), (0.4, 0.8)) + places("+z", (0.5, 0.5))
    yield "second-face-coincident", first + places("+y", (0.4, 0.6), (0.4, 0.6)) + places("+z", (0.5, 0.5))
    line = places("+x", (0.2, 0.2), (0.4, 0.4), (0.7, 0.7))
    yield "first-face-in-a-line", line + places("+y", (0.3, 0.2), (0.7, 0.5)) + places("+z", (0.5, 0.5))
    yield "one-point-a-face", [
        place for name, count in zip(("+x", "+y", "+z"), (3, 2, 1)) for place in places(name, *[(0.5, 0.5)] * count)
    ]


def random_cube(counts):
    spot = lambda: (random.uniform(0.1, 0.9), random.uniform(0.1, 0.9))
    return [
        place for name, count in zip(("+x", "+y", "+z"), counts) for place in places(name, *[spot() for _ in range(count)])
    ]


def families_of_block():
    base = places("base", (0.6, 0.1), (-0.5, 0.6), (-0.3, -0.7))
    # Turning about the base's normal is seen by how far apart the fence's touches are along it, and by nothing else.
    normal = vector(0, 3, 1)
    aside = unit(cross(unit(normal), vector(0, 0, 1)))
    assert abs(aside[2]) < ZERO
    yield "fence-upright", base + places("fence", (0.2, -0.6), (0.2, 0.5)) + places("stop", (0.1, 0.3))
    line = places("base", (0.5, 0.5), (-0.2, -0.2), (-0.6, -0.6))
    yield "base-in-a-line", line + places("fence", (0.6, 0.1), (-0.5, 0.2)) + places("stop", (0.1, 0.3))


def random_block(counts):
    spot = lambda: (random.uniform(-0.9, 0.9) / 1.3, random.uniform(-0.9, 0.9) / 1.3)
    return [
        place
        for name, count in zip(("base", "fence", "stop"), counts)
        for place in places(name, *[spot() for _ in range(count)])
    ]


# Frames.


def rotation():
    q = [gauss() for _ in range(4)]
    norm = mp.sqrt(sum(part * part for part in q))
    w, x, y, z = (part / norm for part in q)
    return mp.matrix(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def frame(number):
    """The parent's own, axes along those of the parent, or anywhere."""
    if number % 3 == 0:
        return mp.eye(3), vector(0, 0, 0)
    if number % 3 == 1:
        return mp.matrix([[0, 0, 1], [1, 0, 0], [0, 1, 0]]), vector(100, -200, 50)
    return rotation(), vector(*(random.uniform(-500, 500) for _ in range(3)))


# What a layout leaves free.


def observed(fixture, contacts, axes):
    rows = mp.zeros(len(contacts), 6)
    for index, (_, point, normal) in enumerate(contacts):
        n = axes * normal
        turn = cross(axes * point, n) / fixture.size
        for k in range(3):
            rows[index, k], rows[index, 3 + k] = n[k], turn[k]
    # The square of the rows: 60 digits leave 30 of a singular value.
    values, vectors = mp.eigsy(rows.T * rows)
    values = [mp.sqrt(max(value, mp.mpf(0))) for value in values]
    largest = max(values)
    smallest = min(values)
    free = [k for k in range(6) if values[k] * FREE < largest]
    condition = None if smallest < largest * mp.mpf("1e-28") else float(largest / smallest)
    return condition, [[float(vectors[row, k]) for row in range(6)] for k in free]


# Other frames that fit: descents from all over in double precision, their ends settled with 60 digits.


def fits(fixture, names, points, rotations, origins):
    """Residuals and their slopes over [v, w] along the fixture's axes, for many frames at once."""
    seen = numpy.einsum("sji,skj->ski", rotations, points[None] - origins[:, None])
    residuals, normals = numpy.empty(seen.shape[:2]), numpy.empty(seen.shape)
    for index, name in enumerate(names):
        residuals[:, index], normals[:, index] = fixture.surfaces[name].many(seen[:, index])
    return residuals, -numpy.concatenate([normals, numpy.cross(seen, normals)], axis=2)


def turned(w):
    """Rotation matrices of rotation vectors."""
    angle = numpy.linalg.norm(w, axis=1)[:, None, None] + 1e-300
    k = numpy.zeros((len(w), 3, 3))
    k[:, 0, 1], k[:, 0, 2], k[:, 1, 2] = -w[:, 2], w[:, 1], -w[:, 0]
    k = (k - k.transpose(0, 2, 1)) / angle
    return numpy.eye(3) + numpy.sin(angle) * k + (1 - numpy.cos(angle)) * (k @ k)


def moved(rotations, origins, step):
    return rotations @ turned(step[:, 3:]), origins + numpy.einsum("sij,sj->si", rotations, step[:, :3])


def ends(fixture, names, points, middle, noise):
    """Ends of Levenberg and Marquardt's descents; `middle` is the mean of the places touched, fixture coordinates."""
    size = float(fixture.size)
    q, _ = numpy.linalg.qr(noise.normal(size=(STARTS, 3, 3)))
    rotations = q * numpy.linalg.det(q)[:, None, None]
    origins = points.mean(axis=0) + noise.normal(size=(STARTS, 3)) * size / 2 - rotations @ middle
    damping = numpy.full(STARTS, 1e-2)
    scale = numpy.array([1, 1, 1, 1 / size, 1 / size, 1 / size])
    residuals, slopes = fits(fixture, names, points, rotations, origins)
    for _ in range(STEPS):
        rows = slopes * scale
        matrix = numpy.einsum("ski,skj->sij", rows, rows) + damping[:, None, None] * numpy.eye(6)
        step = -numpy.linalg.solve(matrix, numpy.einsum("ski,sk->si", rows, residuals)[..., None])[..., 0] * scale
        there = moved(rotations, origins, step)
        tried, tried_slopes = fits(fixture, names, points, *there)
        better = (tried**2).sum(axis=1) < (residuals**2).sum(axis=1)
        rotations[better], origins[better] = there[0][better], there[1][better]
        residuals[better], slopes[better] = tried[better], tried_slopes[better]
        damping = numpy.where(better, numpy.maximum(damping / 5, 1e-14), numpy.minimum(damping * 4, 1e6))
    return rotations, origins, numpy.abs(residuals).max(axis=1)


def settled(fixture, names, points, axes, origin):
    """Gauss and Newton's steps with 60 digits."""
    for _ in range(8):
        rows, residuals = mp.zeros(len(points), 6), mp.zeros(len(points), 1)
        for index, (name, point) in enumerate(zip(names, points)):
            seen = axes.T * (point - origin)
            residuals[index], normal = fixture.surfaces[name].exactly(seen)
            turn = cross(seen, normal)
            for k in range(3):
                rows[index, k], rows[index, 3 + k] = -normal[k], -turn[k] / fixture.size
        step = mp.lu_solve(rows.T * rows, -(rows.T * residuals))
        v, w = vector(*step[:3]), vector(*step[3:]) / fixture.size
        origin += axes * v
        angle = mp.sqrt(dot(w, w))
        if angle > 0:
            k = mp.matrix([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]]) / angle
            axes = axes * (mp.eye(3) + k * mp.sin(angle) + k * k * (1 - mp.cos(angle)))
    return axes, origin, residuals


def second(fixture, contacts, axes, origin, noise):
    """The frame, other than the true one, that fits best and that the fixture's rule of where touches lie allows; and its
    misfit, the root of the sum of squares, in standard deviations."""
    names = [name for name, _, _ in contacts]
    at = [axes * point + origin for _, point, _ in contacts]
    points = numpy.array([[float(x) for x in point] for point in at])
    middle = sum((point for _, point, _ in contacts), vector(0, 0, 0)) / len(contacts)
    rotations, origins, off = ends(fixture, names, points, numpy.array([float(x) for x in middle]), noise)
    best, tried = None, []
    for k in numpy.argsort(off):
        # A settled frame of this misfit would be none that noise explains.
        if off[k] > 1e-5 or len(tried) > 24:
            break
        same = lambda other: (
            numpy.abs(rotations[k] - rotations[other]).max() < 1e-4
            and numpy.abs(origins[k] - origins[other]).max() < 1e-4 * float(fixture.size)
        )
        if any(same(other) for other in tried):
            continue
        tried.append(k)
        try:
            r, t, residuals = settled(fixture, names, at, mp.matrix(rotations[k].tolist()), vector(*origins[k]))
        except ZeroDivisionError:
            continue
        from_truth = max(mp.norm(r - axes), mp.norm(t - origin) / fixture.size)
        if from_truth < mp.mpf("1e-6") or not fixture.may_stand(names, [r.T * (point - t) for point in at]):
            continue
        misfit = float(mp.norm(residuals) / SIGMA)
        if best is None or misfit < best[0]:
            best = misfit, r, t
    return best


def told(axes, origin):
    return [round(float(x), 11) for x in origin] + [round(float(axes[row, k]), 15) for row in range(3) for k in range(3)]


def line(name, fixture, layout, number):
    contacts = []
    for surface, a, b in layout:
        point, normal = fixture.surfaces[surface].at(a, b)
        contacts.append((surface, point, normal))
    axes, origin = frame(number)
    # Off by a twentieth of sigma at most.
    at = lambda point: [round(float(x), 11) for x in axes * point + origin]
    condition, free = observed(fixture, contacts, axes)
    made = {
        "name": name,
        "fixture": FIXTURES.index(fixture),
        "touches": [[surface, *at(point)] for surface, point, _ in contacts],
        "frame": told(axes, origin),
        "condition": condition and float(f"{condition:.6g}"),
    }
    if free:
        made["free"] = [[round(x, 7) for x in motion] for motion in free]
    if condition is not None and condition < SOUND:
        other = second(fixture, contacts, axes, origin, numpy.random.default_rng([SEED, number]))
        if other is not None and other[0] < DOUBTFUL:
            misfit, r, t = other
            made["second"] = {"misfit": round(misfit, 3), "frame": told(r, t)}
    return made


def disturbed(fixture, layout, by):
    by = by * fixture.disturbance
    return [(surface, a + by * gauss(), b + by * gauss()) for surface, a, b in layout]


def main():
    layouts = []
    for fixture, of_fixture in FAMILIES:
        for family, layout in of_fixture:
            for by in DISTURBED:
                for draw in range(3 if by == 0 else 2):
                    how = "exact" if by == 0 else f"1e{mp.nint(mp.log10(by)).__int__()}"
                    name = f"{fixture.kind}/{family}/{how}/{draw}"
                    layouts.append(line(name, fixture, disturbed(fixture, layout, by), len(layouts)))
    for fixture, draw_layout in RANDOM:
        for draw in range(15):
            layout = draw_layout()
            counts = "+".join(str(sum(1 for place in layout if place[0] == name)) for name in fixture.surfaces)
            layouts.append(line(f"{fixture.kind}/random {counts}/{draw}", fixture, layout, len(layouts)))
    compact = lambda value: json.dumps(value, separators=(",", ":"))
    fixtures = ",\n".join(compact(fixture.told()) for fixture in FIXTURES)
    print(f'{{"sigma":{SIGMA},"fixtures":[\n{fixtures}\n],"layouts":[')
    print(",\n".join(compact(layout) for layout in layouts))
    print("]}")


FIRST, SECOND = cylinder_plane(20.0, 45.0), cylinder_plane(12.5, 30.0)
BALLS, CENTERS = three_sphere(12.7, 100.0, 90.0, 80.0)
CUBE, BLOCK = cube(40.0), block()
FIXTURES = [FIRST, SECOND, BALLS, CUBE, BLOCK]
FAMILIES = [
    (FIRST, list(families_of_cylinder_plane())),
    (BALLS, list(families_of_three_sphere(CENTERS))),
    (CUBE, list(families_of_cube())),
    (BLOCK, list(families_of_block())),
]
RANDOM = [
    (FIRST, lambda: random_cylinder_plane(4, 3)),
    (FIRST, lambda: random_cylinder_plane(6, 4)),
    (SECOND, lambda: random_cylinder_plane(5, 3)),
    (BALLS, lambda: random_three_sphere((3, 3, 3))),
    (BALLS, lambda: random_three_sphere((5, 4, 3))),
    (CUBE, lambda: random_cube((3, 2, 1))),
    (CUBE, lambda: random_cube((4, 3, 2))),
    (BLOCK, lambda: random_block((3, 2, 1))),
    (BLOCK, lambda: random_block((4, 3, 2))),
]
main()
