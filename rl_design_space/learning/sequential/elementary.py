"""Exponential and logarithm from additions, multiplications and divisions alone: the same bits on every machine.

Those of mathematical libraries may differ in the last bit, and a bit decides between actions.
"""

from __future__ import annotations

import math

from rl_design_space.learning.compiled import compiled

_LOG2_E, _LN2_HIGH, _LN2_LOW = 1.4426950408889634, 6.93147180369123816490e-01, 1.90821492927058770002e-10
_LN2, _HALF_ROOT = 0.6931471805599453, 0.7071067811865476
#: Below this, e^x is 0 here.
_LEAST = -700.0
#: Coefficients of the series, the highest power first: 1/13!, …, 1/1!, 1/0!; and 1/21, 1/19, …, 1/1.
_OF_EXPONENTIAL = tuple(1.0 / math.factorial(power) for power in range(13, -1, -1))
_OF_LOGARITHM = tuple(1.0 / power for power in range(21, 0, -2))


@compiled
def _polynomial(x, coefficients):
    """Return the value of a polynomial, by Horner's rule."""
    value = 0.0
    for coefficient in coefficients:
        value = value * x + coefficient
    return value


@compiled
def exponential(x):
    """Return e^x of a number that is not positive."""
    if not x > _LEAST:
        return 0.0
    twos = math.floor(x * _LOG2_E + 0.5)
    rest = (x - twos * _LN2_HIGH) - twos * _LN2_LOW
    return math.ldexp(_polynomial(rest, _OF_EXPONENTIAL), int(twos))


@compiled
def logarithm(count):
    """Return the natural logarithm of a number of at least 1."""
    fraction, twos = math.frexp(float(count))
    if fraction < _HALF_ROOT:
        fraction, twos = 2.0 * fraction, twos - 1
    ratio = (fraction - 1.0) / (fraction + 1.0)
    return twos * _LN2 + 2.0 * ratio * _polynomial(ratio * ratio, _OF_LOGARITHM)


@compiled
def to_the_minus(count, power):
    """Return count^(-power) of a number of at least 1."""
    return 1.0 / count if power == 1.0 else exponential(-power * logarithm(count))
