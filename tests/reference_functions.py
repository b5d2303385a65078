"""Exponential function and logarithm as specified, which give the same bits everywhere."""

from __future__ import annotations

import math

_LN2 = 0.6931471805599453


def exponential(x: float) -> float:
    """e^x as specified: by powers of two and a series, in this order."""
    if x <= -700.0:
        return 0.0
    twos = math.floor(x * 1.4426950408889634 + 0.5)
    rest = (x - twos * 6.93147180369123816490e-01) - twos * 1.90821492927058770002e-10
    value = 0.0
    for power in range(13, -1, -1):
        value = value * rest + 1.0 / math.factorial(power)
    return math.ldexp(value, twos)


def logarithm(count: int) -> float:
    fraction, twos = math.frexp(count)
    if fraction < 0.7071067811865476:
        fraction, twos = 2.0 * fraction, twos - 1
    ratio = (fraction - 1.0) / (fraction + 1.0)
    value = 0.0
    for power in range(21, 0, -2):
        value = value * (ratio * ratio) + 1.0 / power
    return twos * _LN2 + 2.0 * ratio * value
