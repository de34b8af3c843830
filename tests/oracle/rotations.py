#!/usr/bin/env python3
"""Independent readings of one rotation in every convention that the dialects use, by scipy.

What
    The twelve rotations by which the conventions are pinned (G1 to G12: plain, hanging, at and near every lock, near pi,
    tiny) and random ones. For each: matrix, quaternion x y z w, rotation vector, and angles in all twelve orders, about
    moving and about fixed axes; written to `rotations.json`. Shares no code with the library: matrices, quaternions and
    angles are scipy's.

Use
    Angles are one of many triples at a lock: the test composes rotations from what the library prints and compares
    these with the matrix. Away from the locks (`regular`) it compares the angles, too.

How to run (needs Python 3.9, numpy 2 and scipy 1.17; a second)
    python3 rotations.py             writes rotations.json beside this script
    python3 rotations.py --check     computes all again and compares the file
"""

import argparse
import json
import sys
import warnings
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

FILE = Path(__file__).resolve().parent / "rotations.json"
ORDERS = ["xyz", "xzy", "yxz", "yzx", "zxy", "zyx", "xyx", "xzx", "yxy", "yzy", "zxz", "zyz"]
# Capitals are moving axes, in scipy.
GOLDEN = [
    ("G1", "ZYX", [30, 20, 10]),
    ("G2", "X", [180]),
    ("G3", "ZYX", [40, 90, 10]),
    ("G4", "ZYX", [40, -90, 10]),
    ("G5", "X", [179.98]),
    ("G6", None, np.deg2rad(0.002) * np.array([1, 2, 3]) / np.sqrt(14)),
    ("G7", "ZYX", [-135, -35, 170]),
    ("G8", "ZYX", [30, 89.9, 10]),
    ("G9", "Z", [30]),
    ("G10", "XYZ", [20, 90, 30]),
    ("G11", "XYZ", [20, -90, 30]),
    ("G12", "ZX", [25, 180]),
]
RANDOM = 40
# Degrees between the middle angle and its lock from which on angles are compared.
FAR = 1.0


def angles(rotation, order):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # at a lock scipy chooses, and says so
        moving = rotation.as_euler(order.upper(), degrees=True)
        fixed = rotation.as_euler(order.lower(), degrees=True)
    middle = moving[1] if order[0] == order[2] else moving[1] + 90
    fixed_middle = fixed[1] if order[0] == order[2] else fixed[1] + 90
    regular = all(FAR < m < 180 - FAR for m in (middle, fixed_middle))
    return {"moving": moving.tolist(), "fixed": fixed.tolist(), "regular": bool(regular)}


def case(name, rotation):
    return {
        "name": name,
        "matrix": rotation.as_matrix().tolist(),
        "quaternion_xyzw": rotation.as_quat(canonical=True).tolist(),
        "rotation_vector": rotation.as_rotvec().tolist(),
        "angles_deg": {order: angles(rotation, order) for order in ORDERS},
    }


def cases():
    for name, order, numbers in GOLDEN:
        if order is None:
            yield case(name, Rotation.from_rotvec(numbers))
        else:
            yield case(name, Rotation.from_euler(order, numbers if len(numbers) > 1 else numbers[0], degrees=True))
    for index, rotation in enumerate(Rotation.random(RANDOM, rng=np.random.default_rng(20240611))):
        yield case(f"random {index}", rotation)


def near(a, b):
    if isinstance(a, dict):
        return a.keys() == b.keys() and all(near(a[key], b[key]) for key in a)
    if isinstance(a, list):
        return len(a) == len(b) and all(near(x, y) for x, y in zip(a, b))
    return abs(a - b) < 1e-9 if isinstance(a, float) else a == b


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true", help="compare with the file instead of writing it")
    check = parser.parse_args().check
    made = json.loads(json.dumps(list(cases())))
    if not check:
        FILE.write_text("[\n" + ",\n".join(json.dumps(one) for one in made) + "\n]\n")
    elif not near(made, json.loads(FILE.read_text())):
        sys.exit("rotations.json differs")
    print(f"{len(made)} rotations")


if __name__ == "__main__":
    main()
