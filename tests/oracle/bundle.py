#!/usr/bin/env python3
"""Independent calibration of a cylinder-plane fixture from four placements, at 50 digits.

What
    Four simulated placements of `cylinder-plane`, nine touches each; radius, angle and tip radius are unknown, with a
    stated uncertainty or without. The likeliest values, their covariance, and the frame of each placement with its
    marginal covariance; written to `bundle.json`. Shares no code and no method with the library.

Model
    As in maximum_likelihood.py: residual d = signed distance of a tip centre less the tip radius, over sigma; each
    stated nominal value is one more observation. Unknowns: six of each frame and the parameters, minimised at once.
    The fixture's frame: Z along the cylinder's axis, the plane through the origin, its outward normal
    (-sin a, 0, cos a). The covariance is the inverse of J^T J at the minimum; of a frame in the order x y z rx ry rz,
    along parent axes, t' = t + dt, R' = exp(dw) R.

Method
    Rotations by Rodrigues' formula about the current axes, derivatives by central differences at 50 digits (step
    1e-16: truncation 1e-32), Gauss-Newton with mpmath's LU on the dense normal equations from the simulated truth until
    every component of the step is below 1e-30.

How to run (needs Python 3.9 and mpmath 1.3; a few seconds)
    python3 bundle.py             writes bundle.json beside this script
    python3 bundle.py --check     simulates and solves all cases again and compares the file
"""

import argparse
import json
import random
import sys
from pathlib import Path

from mpmath import mp, mpf

mp.dps = 50
STEP = mpf(10) ** -16
SETTLED = mpf(10) ** -30
FILE = Path(__file__).resolve().parent / "bundle.json"
SIGMA = 0.005
NOMINAL = {"radius": 20.0, "angle_deg": 45.0, "tip_radius": 1.5}
CASES = [
    {"radius": 0.004, "tip_radius": 0.003},
    {"radius": None},
    {"radius": None, "angle_deg": 0.02, "tip_radius": 0.002},
    {"angle_deg": None},
]


def turned(w, v):
    """Rotates v by the rotation vector w."""
    square = sum(x * x for x in w)
    angle = mp.sqrt(square)
    if angle == 0:
        return v
    k = [x / angle for x in w]
    cross = [k[1] * v[2] - k[2] * v[1], k[2] * v[0] - k[0] * v[2], k[0] * v[1] - k[1] * v[0]]
    along = sum(a * b for a, b in zip(k, v))
    sin, cos = mp.sin(angle), mp.cos(angle)
    return [v[i] * cos + cross[i] * sin + k[i] * along * (1 - cos) for i in range(3)]


def residuals(placement, motion, sizes):
    """Whitened residuals of a placement whose frame is moved by (dt, dw) along parent axes."""
    radius, angle, tip = sizes["radius"], sizes["angle_deg"] * mp.pi / 180, sizes["tip_radius"]
    origin = [a + b for a, b in zip(placement["origin"], motion[:3])]
    axes = [turned(motion[3:], axis) for axis in placement["axes"]]
    result = []
    for surface, at in placement["touches"]:
        p = [a - b for a, b in zip(at, origin)]
        x, y, z = (sum(a * b for a, b in zip(axis, p)) for axis in axes)
        if surface == "cylinder":
            distance = mp.sqrt(x * x + y * y) - radius
        else:
            distance = -mp.sin(angle) * x + mp.cos(angle) * z
        result.append((distance - tip) / mpf(SIGMA))
    return result


def solve(placements, unknown):
    """Minimises over all frames and the unknown parameters at once."""
    names = list(unknown)
    sizes = {name: mpf(value) for name, value in NOMINAL.items()}
    count = 6 * len(placements) + len(names)
    while True:
        blocks = []
        for placement in placements:
            zero = [mpf(0)] * 6
            value = residuals(placement, zero, sizes)
            columns = []
            for k in range(6):
                up = residuals(placement, [STEP * (k == i) for i in range(6)], sizes)
                down = residuals(placement, [-STEP * (k == i) for i in range(6)], sizes)
                columns.append([(a - b) / (2 * STEP) for a, b in zip(up, down)])
            for name in names:
                up = residuals(placement, zero, sizes | {name: sizes[name] + STEP})
                down = residuals(placement, zero, sizes | {name: sizes[name] - STEP})
                columns.append([(a - b) / (2 * STEP) for a, b in zip(up, down)])
            blocks.append((value, columns))
        normal, gradient, chi_square = mp.zeros(count), mp.zeros(count, 1), mpf(0)
        for index, (value, columns) in enumerate(blocks):
            places = [6 * index + k for k in range(6)] + [6 * len(placements) + k for k in range(len(names))]
            chi_square += sum(v * v for v in value)
            for i, a in zip(places, columns):
                gradient[i] += sum(x * y for x, y in zip(a, value))
                for j, b in zip(places, columns):
                    normal[i, j] += sum(x * y for x, y in zip(a, b))
        for k, name in enumerate(names):
            if unknown[name] is not None:
                place, u = 6 * len(placements) + k, mpf(unknown[name])
                deviation = (sizes[name] - mpf(NOMINAL[name])) / u
                chi_square += deviation**2
                gradient[place] += deviation / u
                normal[place, place] += 1 / u**2
        step = mp.lu_solve(normal, -gradient)
        if max(abs(s) for s in step) < SETTLED:
            break
        for index, placement in enumerate(placements):
            motion = [step[6 * index + k] for k in range(6)]
            placement["origin"] = [a + b for a, b in zip(placement["origin"], motion[:3])]
            placement["axes"] = [turned(motion[3:], axis) for axis in placement["axes"]]
        for k, name in enumerate(names):
            sizes[name] += step[6 * len(placements) + k]
    return names, sizes, normal**-1, chi_square


def random_axes(rng):
    axes = [[mpf(int(i == k)) for i in range(3)] for k in range(3)]
    for _ in range(3):
        w = [mpf(rng.uniform(-2, 2)) for _ in range(3)]
        axes = [turned(w, axis) for axis in axes]
    return axes


def simulated(rng, unknown):
    """Touches, as doubles, of four placements, and a start: the truth."""
    off = {name: (u if u is not None else 0.01) * rng.gauss(0, 1) for name, u in unknown.items()}
    true = {name: value + off.get(name, 0.0) for name, value in NOMINAL.items()}
    radius, tip, angle = true["radius"], true["tip_radius"], mpf(true["angle_deg"]) * mp.pi / 180
    placements = []
    for _ in range(4):
        axes, origin = random_axes(rng), [mpf(rng.uniform(-300, 300)) for _ in range(3)]
        contacts = []
        for ring in range(2):
            for quarter in range(3 - ring):
                turn = 2 * mp.pi * (quarter / mpf(3 - ring) + rng.uniform(-0.03, 0.03) + 0.2 * ring)
                height = -60 + 35 * ring
                reach = radius + tip
                contacts.append(("cylinder", [reach * mp.cos(turn), reach * mp.sin(turn), mpf(height)]))
        for quarter in range(4):
            turn = mp.pi * (quarter / mpf(2) + rng.uniform(-0.05, 0.05))
            along, across = 18 * mp.cos(turn), 15 * mp.sin(turn)
            foot = [along * mp.cos(angle), across, along * mp.sin(angle)]
            contacts.append(("plane", [foot[0] - tip * mp.sin(angle), foot[1], foot[2] + tip * mp.cos(angle)]))
        touches = []
        for surface, p in contacts:
            at = [origin[i] + sum(axes[k][i] * p[k] for k in range(3)) for i in range(3)]
            touches.append((surface, [float(v) + SIGMA * rng.gauss(0, 1) for v in at]))
        placements.append({"origin": origin, "axes": axes, "touches": touches})
    return placements


def case(rng, unknown):
    placements = simulated(rng, unknown)
    names, sizes, covariance, chi_square = solve(placements, unknown)
    shared = [6 * len(placements) + k for k in range(len(names))]
    block = lambda places: [[float(covariance[i, j]) for j in places] for i in places]
    return {
        "nominal": NOMINAL,
        "sigma": SIGMA,
        "unknown": unknown,
        "values": [float(sizes[name]) for name in names],
        "covariance": block(shared),
        "chi_square": float(chi_square),
        "placements": [
            {
                "touches": [{"surface": surface, "at": at} for surface, at in placement["touches"]],
                "origin": [float(v) for v in placement["origin"]],
                "axes": [[float(v) for v in axis] for axis in placement["axes"]],
                "covariance": block([6 * index + k for k in range(6)]),
            }
            for index, placement in enumerate(placements)
        ],
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true", help="solve all cases again and compare the file")
    check = parser.parse_args().check
    rng = random.Random(20264)
    cases = ",\n".join(json.dumps(case(rng, unknown)) for unknown in CASES)
    text = f'{{"cases": [\n{cases}\n]}}\n'
    if check:
        if FILE.read_text() != text:
            sys.exit(f"{FILE.name} holds other numbers")
        print(f"{len(CASES)} cases solved again: all numbers as in the file")
    else:
        FILE.write_text(text)


if __name__ == "__main__":
    main()
