"""Refinement by SciPy, a closed form by NumPy and a cylinder by scikit-spatial, timed at the request of
benches/peers/main.rs (method.rs tells the protocol)."""

import pathlib
import platform
import sys
import time

import numpy as np
import scipy
import scipy.optimize
import skspatial
from skspatial.objects import Cylinder

FOLDER = pathlib.Path(sys.argv[1])
NOTHING = np.full(12, np.nan)


class Set:
    def __init__(self, name):
        numbers = np.fromfile(FOLDER / f"{name}.f64")
        self.problems, self.on_cylinder, self.on_plane = numbers[:3].astype(int)
        self.radius, self.angle, self.sigma = numbers[3:6]
        starts, touches = np.split(numbers[6:], [12 * self.problems])
        self.starts = starts.reshape(self.problems, 12)
        self.touches = touches.reshape(self.problems, self.on_cylinder + self.on_plane, 3)
        self.normal = np.array([-np.sin(self.angle), 0.0, np.cos(self.angle)])


class Misfit:
    """Residuals in standard deviations and their derivatives, over the unknowns (g, v) of peers.cpp.

    What was computed for residuals is kept for derivatives.
    """

    def __init__(self, problems, index):
        self.set = problems
        self.touches = problems.touches[index]
        self.rotation, self.origin = problems.starts[index, :9].reshape(3, 3), problems.starts[index, 9:]

    def frame(self, unknowns):
        g, v = unknowns[:3], unknowns[3:]
        x, y, z = g
        f = 2 / (1 + g @ g)
        self.turn = np.array(
            [
                [1 - f * (y * y + z * z), f * (x * y - z), f * (x * z + y)],
                [f * (x * y + z), 1 - f * (x * x + z * z), f * (y * z - x)],
                [f * (x * z - y), f * (y * z + x), 1 - f * (x * x + y * y)],
            ]
        )
        return self.rotation @ self.turn, self.origin + self.rotation @ v

    def residuals(self, unknowns):
        rotation, origin = self.frame(unknowns)
        self.points = (self.touches - origin) @ rotation
        on_cylinder, on_plane = np.split(self.points, [self.set.on_cylinder])
        self.distances = np.hypot(on_cylinder[:, 0], on_cylinder[:, 1])
        return np.concatenate([self.distances - self.set.radius, on_plane @ self.set.normal]) / self.set.sigma

    def derivatives(self, unknowns):
        g = unknowns[:3]
        normals = np.empty_like(self.points)
        normals[: self.set.on_cylinder, :2] = self.points[: self.set.on_cylinder, :2] / self.distances[:, None]
        normals[: self.set.on_cylinder, 2] = 0
        normals[self.set.on_cylinder :] = self.set.normal
        (nx, ny, nz), (px, py, pz) = normals.T, self.points.T
        # moment = normal x point; by g: 2 (moment - moment x g) / (1 + g^2).
        mx, my, mz = ny * pz - nz * py, nz * px - nx * pz, nx * py - ny * px
        x, y, z = g
        rows = np.empty((len(normals), 6))
        rows[:, 0] = mx - (my * z - mz * y)
        rows[:, 1] = my - (mz * x - mx * z)
        rows[:, 2] = mz - (mx * y - my * x)
        rows[:, :3] *= 2 / (1 + g @ g)
        rows[:, 3:] = -normals @ self.turn.T
        return rows / self.set.sigma


def scipy_lm(ftol, xtol, gtol):
    def solve(problems, index):
        misfit = Misfit(problems, index)
        end = scipy.optimize.least_squares(
            misfit.residuals, np.zeros(6), misfit.derivatives, method="lm", ftol=ftol, xtol=xtol, gtol=gtol
        )
        rotation, origin = misfit.frame(end.x)
        return np.concatenate([rotation.ravel(), origin])

    return solve


PLACES = np.arange(7) * (2 * np.pi / 7)
# From the values of a trigonometric polynomial of degree three at PLACES to its coefficients for exp(i k phi), k = 3 .. -3.
TO_COEFFICIENTS = np.exp(-1j * np.outer(np.arange(3, -4, -1), PLACES)) / 7


def numpy_closed_form(problems, index):
    """Four touches on the cylinder and three on the plane: every root by np.roots, the best radius chosen."""
    cylinder, plane = problems.touches[index, :4], problems.touches[index, 4:]
    normal = np.cross(plane[1] - plane[0], plane[2] - plane[0])
    normal /= np.linalg.norm(normal)
    if normal @ (cylinder.mean(axis=0) - plane[0]) > 0:  # The cylinder is behind the plane.
        normal = -normal
    u = np.cross(normal, cylinder[1] - cylinder[0])
    u /= np.linalg.norm(u)
    basis = np.stack([u, np.cross(normal, u), normal])
    p = (cylinder[:3] - cylinder[3]) @ basis.T
    pairs = np.cross(p[[1, 2, 0]], p[[2, 0, 1]])
    sine, cosine = np.sin(problems.angle), np.cos(problems.angle)

    def direction(phi):
        return np.stack([sine * np.cos(phi), sine * np.sin(phi), np.full_like(phi, cosine)], axis=-1)

    s = direction(PLACES)
    squares = (p * p).sum(axis=1) - (s @ p.T) ** 2  # |p x s|^2
    values = (squares * (s @ pairs.T)).sum(axis=1)
    roots = np.roots(TO_COEFFICIENTS @ values)
    roots = roots[np.abs(np.abs(roots) - 1) < 1e-6]
    best = (np.inf, NOTHING)
    for s in direction(np.angle(roots)):
        x = np.cross(s, normal @ basis.T - s * cosine)
        x /= np.linalg.norm(x)
        y = np.cross(s, x)
        # The circle through the projections of the touches: 2 c . q = |q|^2, the fourth at the origin.
        q = p @ np.stack([x, y]).T
        center = np.linalg.lstsq(2 * q, (q * q).sum(axis=1), rcond=None)[0]
        off = abs(np.linalg.norm(center) - problems.radius)
        if off < best[0]:
            z_axis = basis.T @ s
            through = cylinder[3] + basis.T @ (center[0] * x + center[1] * y)
            origin = through + z_axis * ((plane[0] - through) @ normal / cosine)
            y_axis = np.cross(normal, z_axis) / sine
            rotation = np.stack([np.cross(y_axis, z_axis), y_axis, z_axis], axis=1)
            best = off, np.concatenate([rotation.ravel(), origin])
    return best[1]


def cylinder_alone(problems, index):
    """The axis of a cylinder of unknown radius from its touches alone; no origin, and no frame about it."""
    fitted = Cylinder.best_fit(problems.touches[index, : problems.on_cylinder])
    axis = fitted.vector / np.linalg.norm(fitted.vector)
    x = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    x /= np.linalg.norm(x)
    return np.concatenate([np.stack([x, np.cross(axis, x), axis], axis=1).ravel(), fitted.point])


METHODS = {
    "scipy": scipy_lm(1e-8, 1e-9, 1e-12),
    "scipy-tight": scipy_lm(1e-14, 1e-14, 1e-14),
    "numpy-closed-form": numpy_closed_form,
    "scikit-spatial": cylinder_alone,
}


def main():
    versions = [f"{module.__name__} {module.__version__}" for module in (np, scipy)]
    versions.append(f"scikit-spatial {skspatial.__version__}")
    print(", ".join([f"Python {platform.python_version()}", *versions]), flush=True)
    sets = {}
    for line in sys.stdin:
        method, name, count, repeats = line.split()
        if name not in sets:
            sets[name] = Set(name)
        problems, solve = sets[name], METHODS[method]
        start = time.process_time()
        for _ in range(int(repeats)):
            frames = []
            for index in range(int(count)):
                try:
                    frames.append(solve(problems, index))
                except (ValueError, np.linalg.LinAlgError):
                    frames.append(NOTHING)
        seconds = time.process_time() - start
        np.array(frames).tofile(FOLDER / f"{method}.f64")
        print(seconds * 1e9, flush=True)


main()
