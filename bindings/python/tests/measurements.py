"""A thousand measurements of every built-in fixture, sound and not: the same on every machine.

Points are put on the surfaces of a fixture that stands somewhere, by formulas of its own, so that nothing here is shared
with what is tested.
"""

from __future__ import annotations

import math
import random
from typing import Any, NamedTuple, Optional

import touchref

SEED = 20261123
SIGMA = 0.005
TIP_RADIUS = 1.5

Vector = tuple[float, float, float]
Contact = tuple[str, Vector, Vector]
"""Surface, point on it, outward normal there; in fixture coordinates."""


class Placement(NamedTuple):
    """The touches made while the fixture stood at one place."""

    name: str
    labels: list[str]
    touches: list[Vector]
    sigma: Optional[float]
    """Of its touches, where they state their own."""
    approaches: Optional[list[Vector]]


def _unit(v: Vector) -> Vector:
    length = math.sqrt(sum(a * a for a in v))
    return (v[0] / length, v[1] / length, v[2] / length)


def _along(at: Vector, direction: Vector, length: float) -> Vector:
    return (at[0] + length * direction[0], at[1] + length * direction[1], at[2] + length * direction[2])


def _cylinder_plane(draw: random.Random) -> list[Contact]:
    tangent = math.tan(math.radians(45.0))
    normal = (-math.sin(math.radians(45.0)), 0.0, math.cos(math.radians(45.0)))
    contacts: list[Contact] = []
    for _ in range(draw.choice([4, 4, 5])):
        angle = draw.uniform(0.0, 2.0 * math.pi)
        x, y = math.cos(angle), math.sin(angle)
        z = 20.0 * x * tangent - draw.uniform(5.0, 60.0)
        contacts.append(("cylinder", (20.0 * x, 20.0 * y, z), (x, y, 0.0)))
    for _ in range(draw.choice([3, 3, 4])):
        s, t = draw.uniform(-25.0, 25.0), draw.uniform(-18.0, 18.0)
        contacts.append(("plane", (s * normal[2], t, -s * normal[0]), normal))
    return contacts


def _on_ball(draw: random.Random, name: str, center: Vector, radius: float) -> Contact:
    direction = _unit((draw.gauss(0.0, 1.0), draw.gauss(0.0, 1.0), abs(draw.gauss(0.0, 1.0)) + 0.2))
    return (name, _along(center, direction, radius), direction)


def _three_sphere(draw: random.Random) -> list[Contact]:
    ab, bc, ca = 80.0, 90.0, 70.0
    x = (ab * ab + ca * ca - bc * bc) / (2.0 * ab)
    centers = {"a": (0.0, 0.0, 0.0), "b": (ab, 0.0, 0.0), "c": (x, math.sqrt(ca * ca - x * x), 0.0)}
    counts = draw.choice([3, 3, 4])
    return [_on_ball(draw, name, center, 12.0) for name, center in centers.items() for _ in range(counts)]


def _cube(draw: random.Random) -> list[Contact]:
    contacts: list[Contact] = []
    extra = draw.choice([0, 1])
    for axis, count in zip("xyz", draw.sample([3 + extra, 2 + extra, 1 + extra], 3)):
        for _ in range(count):
            at = [draw.uniform(-45.0, -5.0) for _ in range(3)]
            at["xyz".index(axis)] = 0.0
            normal = tuple(float(axis == other) for other in "xyz")
            contacts.append((f"+{axis}", (at[0], at[1], at[2]), (normal[0], normal[1], normal[2])))
    return contacts


BALLS = {"a": (60.0, 0.0, 20.0), "b": (-30.0, 51.9615, 20.0), "c": (-30.0, -51.9615, 20.0)}


def _balls(draw: random.Random) -> list[Contact]:
    contacts: list[Contact] = []
    for _ in range(3):
        contacts.append(("plate", (draw.uniform(-25.0, 25.0), draw.uniform(-25.0, 25.0), 0.0), (0.0, 0.0, 1.0)))
    return contacts + [_on_ball(draw, name, center, 6.35) for name, center in BALLS.items() for _ in range(3)]


def fixtures() -> dict[str, tuple[touchref.Fixture, Any, int]]:
    """By name: the fixture, what touches it, and how often."""
    plate = {"name": "plate", "type": "plane", "point": [0.0, 0.0, 0.0], "normal": [0.0, 0.0, 1.0], "within": 40.0}
    balls = [
        {"name": name, "type": "sphere", "center": list(center), "radius": 6.35} for name, center in BALLS.items()
    ]
    return {
        "cylinder-plane": (touchref.CylinderPlane(radius=20.0, angle_deg=45.0), _cylinder_plane, 400),
        "three-sphere": (touchref.ThreeSphere(radius=12.0, ab=80.0, bc=90.0, ca=70.0), _three_sphere, 280),
        "cube": (touchref.Cube(edge=50.0), _cube, 280),
        "composite": (touchref.Composite(surface=[plate, *balls]), _balls, 40),
    }


def placements(kind: str) -> list[Placement]:
    """The measurements of one fixture."""
    _, touch, count = fixtures()[kind]
    draw = random.Random(f"{SEED} {kind}")
    return [_placement(draw, f"{kind} {index}", touch(draw)) for index in range(count)]


def _rotation(draw: random.Random) -> list[Vector]:
    w, x, y, z = (draw.gauss(0.0, 1.0) for _ in range(4))
    n = math.sqrt(w * w + x * x + y * y + z * z)
    w, x, y, z = w / n, x / n, y / n, z / n
    return [
        (1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
        (2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
        (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)),
    ]


def _turned(rotation: list[Vector], v: Vector) -> Vector:
    x, y, z = (sum(a * b for a, b in zip(row, v)) for row in rotation)
    return (x, y, z)


def _placement(draw: random.Random, name: str, contacts: list[Contact]) -> Placement:
    rotation = _rotation(draw)
    origin = (draw.uniform(-500, 500), draw.uniform(-500, 500), draw.uniform(-500, 500))
    trouble = draw.random()
    if trouble < 0.05:
        # All touches of a surface near one place: some motion is hardly seen, or not at all.
        first = {surface: (at, normal) for surface, at, normal in contacts}
        contacts = [(surface, *first[surface]) for surface, _, _ in contacts]
    elif trouble < 0.09:
        del contacts[draw.randrange(1, len(contacts)) :]
    sigma = draw.choice([0.001, 0.02, 0.2, 2.0]) if 0.09 <= trouble < 0.17 else None
    labels, touches, approaches = [], [], []
    for surface, at, normal in contacts:
        center = _along(at, normal, TIP_RADIUS + draw.gauss(0.0, sigma or SIGMA))
        turned = _turned(rotation, center)
        labels.append(surface)
        touches.append(_along(origin, turned, 1.0))
        back = _turned(rotation, normal)
        approaches.append((-back[0], -back[1], -back[2]))
    which = draw.randrange(len(touches))
    if 0.17 <= trouble < 0.25:
        touches[which] = _along(touches[which], approaches[which], 0.5)
    elif 0.25 <= trouble < 0.27:
        touches[which] = (math.nan, *touches[which][1:])
    elif 0.27 <= trouble < 0.29:
        labels[which] += "x"
    return Placement(name, labels, touches, sigma, approaches if draw.random() < 0.3 else None)
