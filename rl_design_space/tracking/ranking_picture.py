"""A picture of the best points of a sweep with their intervals as SVG, written by hand: a sweep ends at once."""

from __future__ import annotations

import math
from collections.abc import Sequence
from html import escape
from typing import NamedTuple

from rl_design_space.tracking.curve_picture import number

#: Most points, and most characters of their names.
_MOST, _LONGEST = 20, 46
#: Width of a letter, of the scale, of values, of what is between them, and the least of all; height of a row, and of
#: what is above and below the rows.
_LETTER, _SCALE, _VALUE, _GAP, _NARROWEST = 6.6, 315, 90, 14, 500
_ROW, _TOP, _BOTTOM = 17, 26, 8
#: Values are drawn on a logarithmic scale if the largest is so many times the smallest.
_FAR = 4


class Ranked(NamedTuple):
    """A point of a ranking.

    Attributes:
        name: of its run.
        value: that it is ranked by.
        error: half the width of its interval; 0 if it is not known.
        is_best: whether it cannot be told from the best.
    """

    name: str
    value: float
    error: float = 0.0
    is_best: bool = False


def ranking_picture(points: Sequence[Ranked], what: str) -> str:
    """Return the best points of a ranking, each with its interval.

    Args:
        points: all of them, the best first.
        what: they are ranked by.
    """
    shown = points[:_MOST]
    ends = [end for each in shown for end in (each.value - each.error, each.value, each.value + each.error)]
    lowest = min(each.value for each in shown)
    is_logarithmic = lowest > 0 and max(ends) > _FAR * lowest
    # On a logarithmic scale, an interval that reaches 0 ends at the edge.
    low, high = (lowest / 2 if is_logarithmic and min(ends) <= 0 else min(ends)), max(ends)

    ends_at = 2 * _GAP + _LETTER * min(_LONGEST, max(len(each.name) for each in shown))
    left = ends_at + _GAP
    width = max(_NARROWEST, left + _SCALE + _GAP + _VALUE)

    def across(value: float) -> float:
        share = (
            math.log(max(value, low) / low) / math.log(high / low)
            if is_logarithmic
            else (value - low) / (high - low or 1)
        )
        return left + share * _SCALE

    height = _TOP + _ROW * len(shown) + _BOTTOM
    count = f"the {len(shown)} best of {len(points):,}" if len(points) > len(shown) else f"{len(points):,} points"
    intervals = ", bars: 95 % of each by itself" if any(each.error for each in shown) else ""
    heading = f"{what}, {count}{intervals}{', logarithmic' if is_logarithmic else ''}"
    rows = []
    for place, each in enumerate(shown):
        y = _TOP + _ROW * place + _ROW / 2
        color = "#d62728" if each.is_best else "#1f77b4"
        start, end = across(each.value - each.error), across(each.value + each.error)
        name = each.name if len(each.name) <= _LONGEST else f"{each.name[: _LONGEST - 1]}…"
        label = escape(f"★ {name}" if each.is_best else name)
        rows.append(
            f'<text x="{ends_at:.0f}" y="{y + 4:.0f}" text-anchor="end">{label}</text>'
            f'<path d="M{start:.1f} {y}H{end:.1f}" stroke="{color}" stroke-width="2"/>'
            f'<circle cx="{across(each.value):.1f}" cy="{y}" r="3.5" fill="{color}"/>'
            f'<text x="{left + _SCALE + _GAP:.0f}" y="{y + 4:.0f}">{number(each.value)}</text>'
        )
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:.0f}" height="{height}" font-family="sans-serif" '
        f'font-size="12" role="img"><title>{escape(heading)}</title>'
        f'<path d="M0 0H{width:.0f}V{height}H0z" fill="#fff"/><g fill="#333">'
        f'<text x="{2 * _GAP}" y="15">{escape(heading)}</text>{"".join(rows)}</g></svg>'
    )
