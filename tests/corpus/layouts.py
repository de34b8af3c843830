#!/usr/bin/env python3
"""Makes layouts.ndjson: layouts of touches that leave a motion free, nearly do, or do not, one a line.

What each layout leaves free is computed here with 60 digits (mpmath), from the geometry of the fixtures alone: a touch
resists a motion by the normal it meets, so its row is [n, (p - o) x n / size] for a translation of the fixture's origin o
and a rotation about it times the fixture's size, along the parent's axes. No code is shared with touchref.

    python3 layouts.py > layouts.ndjson        needs mpmath; takes some seconds

Keys of a line:
    name        fixture, family and how near, as `cylinder-plane/ring/1e-6/3`
    measurement what a measurement file would say: the fixture, and touches without error but for rounding to doubles
    frame       the frame they were made at: x, y, z, then the rotation matrix row by row
    short       whether some surface is touched less than the fixture demands (coincident or collinear touches)
    condition   largest over smallest singular value of the rows; null where the smallest is zero
    free        orthonormal basis of the motions whose singular value is below the largest over 1e8, [v, w size]
"""

import json
import random

import mpmath as mp

mp.mp.dps = 60
SEED = 20261125
# Beyond this condition a motion counts as free.
FREE = mp.mpf("1e8")
# A singular value below this part of the largest is zero in exact arithmetic.
ZERO = mp.mpf("1e-40")
# How far a degenerate layout is disturbed, in parts of the fixture's size or radians; 0 is not at all.
DISTURBED = [0] + [mp.mpf(10) ** -k for k in range(1, 14)]

# Of a touch, mm: above the rounding of touches a metre away, and so little that a second frame fits by no chance.
SIGMA = 1e-10

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


# Surfaces: from two coordinates of a place on it to the point and the outward normal there, in fixture coordinates.


def cylinder(radius):
    def at(turn, height):
        normal = vector(mp.cos(turn), mp.sin(turn), 0)
        return normal * radius + vector(0, 0, height * radius), normal

    return at


def plane(point, normal, size):
    normal = unit(normal)
    aside = unit(cross(normal, vector(0, 0, 1) if abs(normal[2]) < 0.9 else vector(1, 0, 0)))
    other = cross(normal, aside)

    def at(a, b):
        return point + (aside * a + other * b) * size, normal

    return at


def sphere(center, radius):
    """By longitude and latitude."""

    def at(turn, up):
        normal = vector(mp.cos(up) * mp.cos(turn), mp.cos(up) * mp.sin(turn), mp.sin(up))
        return center + normal * radius, normal

    return at


def face(axis, edge):
    """A face `+axis` of a cube whose corner is the origin and which lies behind it; places in parts of the edge."""

    def at(a, b):
        point, normal = vector(0, 0, 0), vector(0, 0, 0)
        point[(axis + 1) % 3], point[(axis + 2) % 3] = -a * edge, -b * edge
        normal[axis] = 1
        return point, normal

    return at


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


class Fixture:
    def __init__(self, kind, parameters, size, surfaces, disturbance=1):
        self.kind, self.parameters, self.size, self.surfaces = kind, parameters, mp.mpf(size), surfaces
        # Of the coordinates of a place, for a disturbance of one.
        self.disturbance = mp.mpf(disturbance)


def cylinder_plane(radius, angle):
    normal = vector(-mp.sin(rad(angle)), 0, mp.cos(rad(angle)))
    surfaces = {"cylinder": cylinder(mp.mpf(radius)), "plane": plane(vector(0, 0, 0), normal, mp.mpf(radius))}
    return Fixture("cylinder-plane", {"radius": radius, "angle_deg": angle}, radius, surfaces)


def three_sphere(radius, ab, bc, ca):
    """`a` at the origin, `b` on the x axis, `c` on the side of positive y."""
    x = mp.mpf(ab * ab + ca * ca - bc * bc) / (2 * ab)
    centers = [vector(0, 0, 0), vector(ab, 0, 0), vector(x, mp.sqrt(ca * ca - x * x), 0)]
    surfaces = {name: sphere(center, mp.mpf(radius)) for name, center in zip("abc", centers)}
    parameters = {"radius": radius, "ab": ab, "bc": bc, "ca": ca}
    return Fixture("three-sphere", parameters, mp.mpf(ab + bc + ca) / 3, surfaces), centers


def cube(edge):
    surfaces = {f"+{name}": face(axis, mp.mpf(edge)) for axis, name in enumerate("xyz")}
    # Places are parts of the edge, and faces end.
    return Fixture("cube", {"edge": edge}, edge, surfaces, 0.1)


def block():
    """Three planes of a block that are not perpendicular."""
    planes = {
        "base": (vector(0, 0, 0), vector(0, 0, 1)),
        "fence": (vector(0, -30, 10), vector(0, 3, 1)),
        "stop": (vector(-40, 0, 10), vector(4, 1, 0)),
    }
    number = lambda values: [float(value) for value in values]
    tables = [
        {"name": name, "type": "plane", "point": number(point), "normal": number(normal), "within": 40.0}
        for name, (point, normal) in planes.items()
    ]
    # What the composite takes for its size: the largest of distances of the points from their middle and of extents.
    surfaces = {name: plane(point, normal, mp.mpf(40)) for name, (point, normal) in planes.items()}
    return Fixture("composite", {"surface": tables}, 40, surfaces, 0.1)


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


def short(fixture, contacts):
    """Whether some surface has fewer places that differ, or are not in a line, than the fixture demands."""
    demanded = {
        "cylinder-plane": {"cylinder": (4, False), "plane": (3, True)},
        "three-sphere": {name: (3, False) for name in "abc"},
        "cube": {},
        "composite": {},
    }[fixture.kind]
    for name, (count, not_in_a_line) in demanded.items():
        points = [point for surface, point, _ in contacts if surface == name]
        different = []
        for point in points:
            if all(mp.norm(point - other) > ZERO for other in different):
                different.append(point)
        if len(different) < count:
            return True
        if not_in_a_line:
            first = different[0]
            spans = [cross(different[1] - first, point - first) for point in different[2:]]
            if all(mp.norm(span) < ZERO for span in spans):
                return True
    return False


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


def line(name, fixture, layout, number):
    contacts = []
    for surface, a, b in layout:
        point, normal = fixture.surfaces[surface](a, b)
        contacts.append((surface, point, normal))
    axes, origin = frame(number)
    at = lambda point: [float(x) for x in axes * point + origin]
    measurement = {
        "units": "mm",
        "fixture": {"kind": fixture.kind, **fixture.parameters},
        "probe": {"sigma": SIGMA},
        "touch": [{"surface": surface, "at": at(point)} for surface, point, _ in contacts],
    }
    condition, free = observed(fixture, contacts, axes)
    print(
        json.dumps(
            {
                "name": name,
                "measurement": measurement,
                "frame": [float(x) for x in origin] + [float(axes[row, k]) for row in range(3) for k in range(3)],
                "short": short(fixture, contacts),
                "condition": condition,
                "free": free,
            }
        )
    )


def disturbed(fixture, layout, by):
    by = by * fixture.disturbance
    return [(surface, a + by * gauss(), b + by * gauss()) for surface, a, b in layout]


def main():
    first, second = cylinder_plane(20.0, 45.0), cylinder_plane(12.5, 30.0)
    balls, centers = three_sphere(12.7, 100.0, 90.0, 80.0)
    families = [
        (first, list(families_of_cylinder_plane())),
        (balls, list(families_of_three_sphere(centers))),
        (cube(40.0), list(families_of_cube())),
        (block(), list(families_of_block())),
    ]
    number = 0
    for fixture, of_fixture in families:
        for family, layout in of_fixture:
            for by in DISTURBED:
                for draw in range(3 if by == 0 else 2):
                    how = "exact" if by == 0 else f"1e{mp.nint(mp.log10(by)).__int__()}"
                    line(f"{fixture.kind}/{family}/{how}/{draw}", fixture, disturbed(fixture, layout, by), number)
                    number += 1
    layouts = [
        (first, lambda: random_cylinder_plane(4, 3)),
        (first, lambda: random_cylinder_plane(6, 4)),
        (second, lambda: random_cylinder_plane(5, 3)),
        (balls, lambda: random_three_sphere((3, 3, 3))),
        (balls, lambda: random_three_sphere((5, 4, 3))),
        (cube(40.0), lambda: random_cube((3, 2, 1))),
        (cube(40.0), lambda: random_cube((4, 3, 2))),
        (block(), lambda: random_block((3, 2, 1))),
        (block(), lambda: random_block((4, 3, 2))),
    ]
    for fixture, draw_layout in layouts:
        for draw in range(15):
            layout = draw_layout()
            counts = "+".join(str(sum(1 for place in layout if place[0] == name)) for name in fixture.surfaces)
            line(f"{fixture.kind}/random {counts}/{draw}", fixture, layout, number)
            number += 1


main()
