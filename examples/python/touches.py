"""A table of touches to try the examples on: a cube that was probed at many places, its rows out of order.

The column ``touch`` numbers the touches of a placement. An engine for large tables keeps no order of rows; sorted by
``placement, touch`` they are as they were measured.
"""

import random

import pyarrow as pa
import touchref

FIXTURE = touchref.Cube(edge=50.0)
PROBE = {"tip_radius": 1.5, "sigma": 0.005}


def touches(placements: int) -> pa.Table:
    """Three touches on each of three faces, moved along X and Y as the placement's number says."""
    faces = {
        "+x": [(0.0, -10.0, -10.0), (0.0, -40.0, -12.0), (0.0, -25.0, -42.0)],
        "+y": [(-10.0, 0.0, -14.0), (-42.0, 0.0, -10.0), (-25.0, 0.0, -40.0)],
        "+z": [(-8.0, -10.0, 0.0), (-41.0, -12.0, 0.0), (-22.0, -44.0, 0.0)],
    }
    draw = random.Random(20261123)
    rows = []
    for placement in range(placements):
        for touch, (surface, at) in enumerate((face, at) for face, points in faces.items() for at in points):
            x, y, z = (
                value + PROBE["tip_radius"] * (surface[1] == axis) + draw.gauss(0.0, PROBE["sigma"])
                for axis, value in zip("xyz", at)
            )
            rows.append((f"p{placement:06}", touch, surface, x + 1.5 * placement, y - placement, z))
    draw.shuffle(rows)
    names = ("placement", "touch", "surface", "x", "y", "z")
    return pa.table(dict(zip(names, map(list, zip(*rows)))))


def on_one_machine(table: pa.Table) -> pa.Table:
    """The frames without any engine."""
    ordered = table.sort_by([("placement", "ascending"), ("touch", "ascending")])
    return pa.table(touchref.batch(ordered, FIXTURE, **PROBE))
