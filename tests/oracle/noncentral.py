"""Power of a chi-square test: the numbers of tests/drift.rs, from the Poisson mixture that defines noncentral chi-square.

    python3 tests/oracle/noncentral.py

Needs mpmath. A squared distance of `nu` degrees of freedom, its mean motion three standard deviations, beyond the level that
nothing exceeds with a chance of 5 %.
"""

import mpmath

mpmath.mp.dps = 30


def tail(x, nu):
    """Chance that chi-square with nu degrees of freedom exceeds x."""
    return mpmath.gammainc(mpmath.mpf(nu) / 2, x / 2, regularized=True)


def power(nu, noncentrality, alpha):
    level = mpmath.findroot(lambda x: tail(x, nu) - alpha, 2 * nu)
    half = mpmath.mpf(noncentrality) / 2
    weight = lambda j: mpmath.exp(-half) * half**j / mpmath.factorial(j)
    return mpmath.nsum(lambda j: weight(j) * tail(level, nu + 2 * j), [0, 150], method="direct")


for nu in (6, 5):
    print(nu, mpmath.nstr(power(nu, 9, mpmath.mpf("0.05")), 9))
