"""A small picture of a learning curve as SVG: written by hand, because a run is recorded within milliseconds."""

from __future__ import annotations

import math
from collections.abc import Sequence

#: Size of the picture, and of the area of the curve within it: the description of a run shows it without a click.
_WIDTH, _HEIGHT = 420, 84
_LEFT, _RIGHT, _TOP, _BOTTOM = 46, 374, 8, 66
#: Most points of a curve.
_MOST = 150


def curve_picture(curve: Sequence[float], optimum: float | None = None) -> str:
    """Return a learning curve on a logarithmic scale, with its first and last value.

    Args:
        curve: mean steps of each trial, above 0.
        optimum: fewest steps possible, drawn as a dashed line; None if it changes between trials.
    """
    last = len(curve) - 1
    trials = sorted({*range(0, len(curve), 1 + last // _MOST), last})
    levels = [*curve, *([] if optimum is None else [optimum])]
    low, high = math.log(min(levels)), math.log(max(levels))
    down = (_BOTTOM - _TOP) / (high - low or 1)
    right = (_RIGHT - _LEFT) / (last or 1)

    def height(value: float) -> float:
        return _TOP + (high - math.log(value)) * down

    points = " ".join(f"{_LEFT + trial * right:.1f},{height(curve[trial]):.1f}" for trial in trials)
    line = (
        ""
        if optimum is None
        else f'<path d="M{_LEFT} {height(optimum):.1f}H{_RIGHT}" stroke="#888" stroke-dasharray="3 3"/>'
    )
    first, end = height(curve[0]), height(curve[-1])
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{_WIDTH}" height="{_HEIGHT}" font-family="sans-serif" '
        'font-size="11" role="img"><title>Steps of a trial, mean over periods</title>'
        f'<path d="M0 0H{_WIDTH}V{_HEIGHT}H0z" fill="#fff"/>{line}'
        f'<polyline points="{points}" fill="none" stroke="#1f77b4" stroke-width="1.5"/>'
        f'<g fill="#444"><text x="{_LEFT - 5}" y="{first + 4:.0f}" text-anchor="end">{number(curve[0])}</text>'
        f'<text x="{_RIGHT + 5}" y="{end + 4:.0f}">{number(curve[-1])}</text>'
        f'<text x="{_LEFT}" y="{_HEIGHT - 4}">trial 1</text>'
        f'<text x="{_RIGHT}" y="{_HEIGHT - 4}" text-anchor="end">{len(curve):,}</text></g></svg>'
    )


def number(value: float) -> str:
    """Return a number with three digits or all of its whole ones."""
    return f"{value:,.0f}" if value >= 100 else f"{value:.3g}"
