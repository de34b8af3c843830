#!/usr/bin/env python3
"""Least-squares frames of a real cylinder-plane measurement, independent of the library.

What
    The QIF "Cheese Block" inspection: 18 touches of a bore and 4 of an oblique plane, uncompensated ball centres of a
    CMM. Prints the frame that minimises the sum of squared distances (a touch's distance from its surface along the
    normal, tip removed; all weights equal) with (i) the radius free, (ii) the radius held at 15.0555, (iii) held at
    the nominal 15.000, which the part does not have. The angle, 39.996 degrees, is held.

Method
    Unknowns: the axis' slopes dx/dz and dy/dz and its point at the height of the bore touches' centroid, the turn of
    the plane's normal about the axis, the plane's offset, and the radius. scipy's `least_squares` from nine axis
    directions (within 35 degrees of the parent's z; the ball's path is two rings across it) with eight turns of the
    normal each; the best minimum is kept, others that were met are named. It is then polished by Gauss-Newton steps
    at 40 digits until they fall below 1e-20, so that every printed digit holds.

Frame
    Z along the axis with n . Z > 0 (cylinder_side behind: the touches of the bore lie below the plane), Y = n x Z
    normalised, X = Y x Z, origin where the axis meets the plane.

How to run (needs Python 3.9, numpy, scipy and mpmath)
    python3 cheese_block.py PATH/TO/qif_cheese_block/cylinder_plane.csv

    The table has the columns surface, x, y, z. Data: github.com/QualityInformationFramework/qif-community, commit
    360b05e, samples/Results/QIF_PTS_SAMPLE.QIF, features CYL_1 and POINT1 to POINT4 (Boost Software License 1.0).
"""

# prints:
#   (i) radius free
#     radius    15.055470308281
#     origin   -19.461659047098   19.654530415622   22.565329227588
#     x_axis     0.999999997342    0.000072873913    0.000002104411
#     y_axis    -0.000072871358    0.999999290041   -0.001189372929
#     z_axis    -0.000002191084    0.001189372772    0.999999292694
#     rms 0.0019936848; with 15 degrees of freedom 0.0024144722
#     largest residual 0.0034724259
#     rms of other minima met: none
#   (ii) radius held at 15.0555
#     radius    15.055500000000
#     origin   -19.461656908525   19.654513674048   22.565331125879
#     x_axis     0.999999997370    0.000072492804    0.000002106146
#     y_axis    -0.000072490249    0.999999290449   -0.001189053197
#     z_axis    -0.000002192342    0.001189053041    0.999999293074
#     rms 0.0019938588; with 16 degrees of freedom 0.0023380067
#     largest residual 0.0034724390
#     rms of other minima met: none
#   (iii) radius held at 15.000
#     radius    15.000000000000
#     origin   -19.465664526466   19.712720983918   22.561715897835
#     x_axis     0.999997959220    0.002020280774   -0.000004618353
#     y_axis    -0.002020285762    0.999993974030   -0.002823180755
#     z_axis    -0.000001085293    0.002823184324    0.999996014807
#     rms 0.0492526781; with 16 degrees of freedom 0.0577538844
#     largest residual 0.0708102421
#     rms of other minima met: none

import argparse
import csv
import itertools
import math

import numpy as np
from mpmath import mp
from scipy.optimize import least_squares

mp.dps = 40
ANGLE_DEG = 39.996
TIP = 2.49978271104
STARTS = list(itertools.product((0.0, -0.5, 0.5), (0.0, -0.5, 0.5), (k * math.pi / 4 for k in range(8))))


def read(path):
    """Ball centres of the bore and of the plane."""
    with open(path, newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))

    def of(surface):
        return [[float(row[c]) for c in "xyz"] for row in rows if row["surface"] == surface]

    return of("cylinder"), of("plane")


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


class Fit:
    """The least-squares problem; `held` is the radius, or None where it is free."""

    def __init__(self, bore, plane, held):
        self.bore, self.plane, self.held = bore, plane, held
        self.center = [sum(p[k] for p in bore) / len(bore) for k in range(3)]

    def geometry(self, unknowns, m):
        """Point and direction of the axis, and the plane's outward normal; `m` is `math` or `mp`."""
        slope_x, slope_y, shift_x, shift_y, turn = unknowns[:5]
        length = m.sqrt(slope_x * slope_x + slope_y * slope_y + 1)
        z = [slope_x / length, slope_y / length, 1 / length]
        level = m.sqrt(z[0] * z[0] + z[2] * z[2])
        e1 = [z[2] / level, 0, -z[0] / level]
        e2 = cross(z, e1)
        ca, sa = m.cos(m.radians(ANGLE_DEG)), m.sin(m.radians(ANGLE_DEG))
        ct, st = m.cos(turn), m.sin(turn)
        n = [ca * z[k] + sa * (ct * e1[k] + st * e2[k]) for k in range(3)]
        return [self.center[0] + shift_x, self.center[1] + shift_y, self.center[2]], z, n

    def residuals(self, unknowns, m=math):
        point, z, n = self.geometry(unknowns, m)
        radius = unknowns[6] if self.held is None else self.held
        out = []
        for p in self.bore:
            q = cross([p[k] - point[k] for k in range(3)], z)
            # In a bore the outward normal points to the axis: distance = radius - from the axis, less the tip.
            out.append(radius - m.sqrt(dot(q, q)) - TIP)
        for p in self.plane:
            out.append(dot(n, [p[k] - self.center[k] for k in range(3)]) - unknowns[5] - TIP)
        return out

    def minima(self):
        """(Sum of squares, unknowns) of every minimum that was met, the best first."""
        found = []
        for slope_x, slope_y, turn in STARTS:
            start = [slope_x, slope_y, 0.0, 0.0, turn, 0.0] + ([15.0] if self.held is None else [])
            result = least_squares(self.residuals, start, xtol=1e-12, ftol=1e-12, gtol=1e-12, x_scale="jac")
            squares = 2 * result.cost
            _, _, n = self.geometry(result.x, math)
            below = all(dot(n, p) < dot(n, self.center) + result.x[5] for p in self.bore)
            if below and not any(abs(squares - other) < 1e-4 * other for other, _ in found):
                found.append((squares, list(result.x)))
        return sorted(found)

    def polished(self, unknowns):
        """The same minimum to 20 digits."""
        unknowns, step = [mp.mpf(u) for u in unknowns], mp.mpf(10) ** -15
        for _ in range(500):
            columns = []
            for k in range(len(unknowns)):
                ends = []
                for sign in (1, -1):
                    moved = list(unknowns)
                    moved[k] += sign * step
                    ends.append(self.residuals(moved, mp))
                columns.append([(a - b) / (2 * step) for a, b in zip(*ends)])
            change = mp.lu_solve(mp.matrix(columns).T, -mp.matrix(self.residuals(unknowns, mp)))
            unknowns = [u + c for u, c in zip(unknowns, change)]
            if mp.norm(change) < mp.mpf(10) ** -20:
                return unknowns
        raise ArithmeticError("Gauss-Newton did not settle")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("table", help="cylinder_plane.csv")
    bore, plane = read(parser.parse_args().table)
    for title, held in (
        ("(i) radius free", None),
        ("(ii) radius held at 15.0555", 15.0555),
        ("(iii) radius held at 15.000", 15.0),
    ):
        fit = Fit(bore, plane, held)
        minima = fit.minima()
        unknowns = fit.polished(minima[0][1])
        point, z, n = fit.geometry(unknowns, mp)
        level = unknowns[5] - dot(n, [point[k] - fit.center[k] for k in range(3)])
        origin = [point[k] + z[k] * level / dot(n, z) for k in range(3)]
        y = cross(n, z)
        y = [c / mp.sqrt(dot(y, y)) for c in y]
        miss = np.array(fit.residuals(unknowns, mp), dtype=float)
        freedom = len(miss) - len(unknowns)
        print(title)
        print(f"  radius  {float(unknowns[6] if held is None else held):17.12f}")
        for name, vector in (("origin", origin), ("x_axis", cross(y, z)), ("y_axis", y), ("z_axis", z)):
            print(f"  {name}  " + " ".join(f"{float(c):17.12f}" for c in vector))
        spread = math.sqrt(miss @ miss / freedom)
        print(f"  rms {math.sqrt(np.mean(miss**2)):.10f}; with {freedom} degrees of freedom {spread:.10f}")
        print(f"  largest residual {abs(miss).max():.10f}")
        print(
            "  rms of other minima met:",
            ", ".join(f"{math.sqrt(s / len(miss)):.4f}" for s, _ in minima[1:]) or "none",
        )


if __name__ == "__main__":
    main()
