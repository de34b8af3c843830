#!/usr/bin/env python3
"""The numbers that `propagation.rs` expects, from closed forms and quadrature.

What
    Moments and distribution functions of the distributions of JCGM 101 (from their densities, by quadrature); exact
    coverage intervals of the sums of JCGM 101 9.2.3 and 9.2.4 (distribution function of the sum of rectangular
    quantities, by inclusion and exclusion), of 9.4 without correlation (noncentral chi-square) and of the logarithm of a
    rectangular quantity; mean, standard deviation and 95 % interval of NIST TN 1900 E3 (quadrature over its three
    uncertain factors; densities by the delta method, as they count 1e-7 of the variance). Shares no code with the library.

Usage
    python3 analysis/tests/propagation.py       prints all of them; needs mpmath and scipy
"""

from itertools import product

import numpy as np
from mpmath import asin, beta, diff, factorial, findroot, log, mp, mpf, npdf, pi, quad, sqrt
from scipy import optimize, stats

mp.dps = 25


def distributions():
    """Name, density, pieces of the support, and points at which the distribution function is asked for."""
    nu = 7
    student = lambda x: (1 + ((x - 2) / 3) ** 2 / nu) ** (-mpf(nu + 1) / 2) / (3 * sqrt(nu) * beta(mpf(1) / 2, mpf(nu) / 2))
    trapezoid = lambda x: min(mpf(1), (1 - abs(x - 3) / 2) / (1 - mpf("0.4"))) / (2 * (1 + mpf("0.4")))
    # Rectangular -1 +- 0.3 to 1 +- 0.3: the density at x averages 1/(2 w) over half-widths w beyond |x|.
    ctrap = lambda x: log(mpf("1.3") / max(abs(x), mpf("0.7"))) / (4 * mpf("0.3"))
    yield "normal 2, 3", lambda x: npdf(x, 2, 3), [-40, 2, 40], [0, 3, 7]
    yield "student 2, 3, nu 7", student, [-10**9, -1000, -50, 2, 50, 1000, 10**9], [0, 3, 7]
    yield "rectangular 1, 5", lambda x: mpf(1) / 4, [1, 5], [mpf("1.5"), 3, mpf("4.6")]
    yield "triangular 1, 5", lambda x: (1 - abs(x - 3) / 2) / 2, [1, 3, 5], [mpf("1.5"), 3, mpf("4.6")]
    yield "trapezoidal 1, 5, top 0.4", trapezoid, [1, mpf("2.2"), mpf("3.8"), 5], [mpf("1.5"), 3, mpf("4.6")]
    yield "curvilinear -1, 1, 0.3", ctrap, [mpf("-1.3"), mpf("-0.7"), mpf("0.7"), mpf("1.3")], [mpf("-0.9"), mpf("0.2"), mpf("1.1")]


for name, density, pieces, points in distributions():
    moment = lambda f: quad(lambda x: f(x) * density(x), pieces)
    mean = moment(lambda x: x)
    u = sqrt(moment(lambda x: (x - mean) ** 2))
    below = [quad(density, [p for p in pieces if p < x] + [x]) for x in points]
    print(f"{name}: mean {mp.nstr(mean, 15)} u {mp.nstr(u, 15)} below {[mp.nstr(b, 12) for b in below]}")
# The arcsine has infinite density at its ends: its distribution function is in closed form, its u that of a sine.
below = [mp.nstr(mpf(1) / 2 + asin((x - 3) / 2) / pi, 12) for x in (mpf("1.5"), 3, mpf("4.6"))]
print(f"arcsine 1, 5: mean 3 u {mp.nstr(sqrt(2), 15)} below {below}")


def rectangular_sum(half_widths, x):
    """Distribution function of a sum of rectangular quantities about zero."""
    n = len(half_widths)
    total = mpf(0)
    for signs in product((-1, 1), repeat=n):
        corner = x + sum(s * h for s, h in zip(signs, half_widths))
        if corner > 0:
            sign = 1
            for s in signs:
                sign *= s
            total += sign * corner**n
    scale = mpf(1)
    for h in half_widths:
        scale *= 2 * h
    return total / (factorial(n) * scale)


for name, u, start in [("9.2.3", [1, 1, 1, 1], "3.88"), ("9.2.4", [1, 1, 1, 10], "17.0")]:
    half_widths = [k * sqrt(3) for k in u]
    end = findroot(lambda x: rectangular_sum(half_widths, x) - mpf("0.975"), mpf(start))
    print(f"{name}: u {mp.nstr(sqrt(sum(k * k for k in u)), 10)} end {mp.nstr(end, 12)}")

for x1 in (0, 0.010, 0.050):
    shape = (x1 / 0.005) ** 2
    law = stats.ncx2(2, shape) if shape else stats.chi2(2)
    length = lambda p: law.ppf(p + 0.95) - law.ppf(p)
    grid = np.linspace(0, 0.05, 5001)[:-1]
    p = grid[np.argmin([length(p) for p in grid])]
    if p > 0:
        p = optimize.minimize_scalar(length, bounds=(p - 1e-5, p + 1e-5), method="bounded").x
    print(f"9.4 x1 {x1}: mean {25 * law.mean():.6f} u {25 * law.std():.6f} [{25 * law.ppf(p):.4f}, {25 * law.ppf(p + 0.95):.4f}]")

primitive = lambda x, k: quad(lambda t: log(t) ** k, [mpf("0.1"), x])
mean = primitive(mpf("1.1"), 1)
print(f"ln x: mean {mp.nstr(mean, 12)} u {mp.nstr(sqrt(primitive(mpf('1.1'), 2) - mean**2), 12)} [{mp.nstr(log(mpf('0.15')), 12)}, {mp.nstr(log(mpf('1.1')), 12)}]")

# E3: viscosity factor a, travel times m and c; the ball sinks, so that c > 0 (its chance below is 1e-11).
nodes, weights = np.polynomial.legendre.leggauss(400)
z, w = 6 * nodes, 6 * weights * stats.norm.pdf(6 * nodes)
ratio = 1037 / 1407
slopes = np.array([1 / 1407 - 1037 / 1407**2, -1 / 1407, 1037 / 1407**2]) * 0.5
relative = np.sqrt((slopes @ slopes) / ratio**2 + 0.01**2)
a, c = 4.63 * ratio * (1 + relative * z)[:, None], (36.6 + 5.49 * z)[None, :]
weight = w[:, None] * w[None, :]
below = lambda q: (weight * stats.norm.cdf((q * c / a - 61) / 6.1)).sum()
mean = (weight * a * 61 / c).sum()
u = np.sqrt((weight * (a / c) ** 2 * (61**2 + 6.1**2)).sum() - mean**2)
ends = [optimize.brentq(lambda q: below(q) - p, 1, 30) for p in (0.025, 0.975)]
print(f"TN 1900 E3: mean {mean:.6f} u {u:.6f} {ends}")
