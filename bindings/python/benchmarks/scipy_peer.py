#!/usr/bin/env python3
"""touchref beside ``scipy.optimize.least_squares``: the same problems, from the same start.

    python scipy_peer.py [MEASUREMENTS]

The distances of points from surfaces are written here anew, in NumPy. scipy descends from a frame near the true one;
touchref is told the same frame (``near``), looks for every other frame, too, and judges what it found. Prints how far the
two frames are apart, in standard deviations, and what each took. Fails where they differ.
"""

from __future__ import annotations

import random
import sys
import time
from pathlib import Path
from statistics import median
from typing import Any, Callable

import numpy as np
import touchref
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))
import measurements  # noqa: E402

Array = NDArray[np.float64]

APART = 1e-5
"""Standard deviations by which frames may differ. scipy stops where the sum of some ten squares changes by 1e-15 of itself,
which is 1e-7 standard deviations, and its derivatives are differences, to some ten digits; touchref stops no later."""


def distances(kind: str) -> dict[str, Callable[[Array], Array]]:
    """Of points (n, 3) in fixture coordinates from the surfaces, by name."""

    def plane(normal: Array) -> Callable[[Array], Array]:
        return lambda points: points @ normal

    def ball(center: Any, radius: float) -> Callable[[Array], Array]:
        return lambda points: np.linalg.norm(points - np.asarray(center), axis=1) - radius

    half = np.sqrt(0.5)
    if kind == "cylinder-plane":
        return {"cylinder": lambda p: np.hypot(p[:, 0], p[:, 1]) - 20.0, "plane": plane(np.array([-half, 0, half]))}
    if kind == "three-sphere":
        x = (80.0**2 + 70.0**2 - 90.0**2) / 160.0
        centers = {"a": (0, 0, 0), "b": (80.0, 0, 0), "c": (x, np.sqrt(70.0**2 - x**2), 0)}
        return {name: ball(center, 12.0) for name, center in centers.items()}
    if kind == "cube":
        return {f"+{axis}": plane(np.eye(3)[index]) for index, axis in enumerate("xyz")}
    balls = {name: ball(center, 6.35) for name, center in measurements.BALLS.items()}
    return {"plate": plane(np.array([0.0, 0.0, 1.0])), **balls}


def peer(kind: str, placement: measurements.Placement, start: Array) -> tuple[Array, float, float]:
    """What scipy makes of it: the frame's matrix, the sum of squares, seconds."""
    of_surface = distances(kind)
    at, labels = np.array(placement.touches), np.array(placement.labels)
    on = [(np.flatnonzero(labels == name), distance) for name, distance in of_surface.items() if name in labels]
    sigma = placement.sigma or measurements.SIGMA
    turned = Rotation.from_matrix(start[:3, :3])

    def frame(x: Array) -> tuple[Rotation, Array]:
        return Rotation.from_rotvec(x[3:]) * turned, start[:3, 3] + x[:3]

    def residuals(x: Array) -> Array:
        rotation, origin = frame(x)
        points = rotation.inv().apply(at - origin)
        found = np.empty(len(at))
        for rows, distance in on:
            found[rows] = distance(points[rows])
        return (found - measurements.TIP_RADIUS) / sigma

    began = time.perf_counter()
    scale = np.array([1, 1, 1, 0.02, 0.02, 0.02])
    result = least_squares(
        residuals, np.zeros(6), method="lm", jac="3-point", x_scale=scale, xtol=1e-15, ftol=1e-15, gtol=1e-15
    )
    took = time.perf_counter() - began
    rotation, origin = frame(result.x)
    matrix: Array = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = rotation.as_matrix(), origin
    return matrix, 2.0 * float(result.cost), took


def displaced(matrix: Array, draw: random.Random) -> Array:
    """A frame some tenths of a millimetre and some milliradians away."""
    near: Array = matrix.copy()
    near[:3, :3] = Rotation.from_rotvec([draw.gauss(0, 3e-3) for _ in range(3)]).as_matrix() @ matrix[:3, :3]
    near[:3, 3] += [draw.gauss(0.0, 0.2) for _ in range(3)]
    return near


def apart(solution: touchref.Solution, matrix: Array) -> float:
    """How far another frame is from a solution, in standard deviations of the latter."""
    frame, covariance = solution.frame, solution.covariance
    assert covariance is not None
    turn = Rotation.from_matrix(matrix[:3, :3] @ frame.matrix[:3, :3].T).as_rotvec()
    error = np.concatenate([matrix[:3, 3] - frame.origin, turn])
    # Along standard deviations, as lengths and angles are of other sizes.
    scale = np.sqrt(np.diag(covariance))
    correlation = covariance / np.outer(scale, scale)
    return float(np.sqrt((error / scale) @ np.linalg.solve(correlation, error / scale)))


def compare(kind: str, count: int) -> None:
    """Compares the first sound measurements of one fixture, and prints a line."""
    fixture = measurements.fixtures()[kind][0]
    draw = random.Random(kind)
    far, squares, ours, theirs = [], [], [], []
    for placement in measurements.placements(kind):
        sigma = placement.sigma or measurements.SIGMA
        arguments: Any = {"tip_radius": measurements.TIP_RADIUS, "sigma": sigma, "approaches": placement.approaches}
        solver = touchref.LeastSquares(margin="near")
        try:
            found = touchref.locate(fixture, placement.touches, placement.labels, solver=solver, **arguments)
        except touchref.TouchrefError:
            continue
        start = displaced(found.frame.matrix, draw)
        measured = touchref.Measurement(fixture, placement.touches, placement.labels, **arguments)
        began = time.perf_counter()
        solution = measured.locate(solver=solver, near=start)
        ours.append(time.perf_counter() - began)
        matrix, chi_square, took = peer(kind, placement, start)
        theirs.append(took)
        far.append(apart(solution, matrix))
        assert solution.chi_square is not None
        squares.append(solution.chi_square - chi_square)
        if len(far) == count:
            break
    assert len(far) >= min(count, 20), f"{kind}: {len(far)} sound measurements only"
    assert max(far) < APART, f"{kind}: {max(far)} standard deviations apart"
    # Where scipy stops a little early its sum is the larger one; never ours.
    assert max(squares) < 1e-9, f"{kind}: the sum of squares is larger by {max(squares)}"
    micro = [f"{1e6 * median(times):10.0f} us" for times in (ours, theirs)]
    print(f"{kind:15} {len(far):5} {max(far):12.1e} {micro[0]} {micro[1]}  {median(theirs) / median(ours):6.1f}")


def main() -> None:
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 100
    print("                frames   sigma apart      touchref         scipy   ratio (medians)")
    for kind in measurements.fixtures():
        compare(kind, count)


if __name__ == "__main__":
    main()
