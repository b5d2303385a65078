"""The pictures of runs and sweeps, which are written by hand as SVG."""

from __future__ import annotations

from xml.etree import ElementTree

import pytest

from rl_design_space.tracking.curve_picture import curve_picture
from rl_design_space.tracking.ranking_picture import Ranked, ranking_picture

SVG = "{http://www.w3.org/2000/svg}"


def texts(picture: str) -> list[str]:
    return [each.text or "" for each in ElementTree.fromstring(picture).iter(f"{SVG}text")]


@pytest.mark.parametrize("trials", [1, 2, 100, 20_000])
def test_a_curve_is_small_and_says_where_it_begins_and_ends(trials: int):
    curve = [1000.0 / (trial + 1) + 12.5 for trial in range(trials)]
    picture = curve_picture(curve, 10.0)
    assert len(picture) < 4000
    assert texts(picture) == [
        f"{curve[0]:,.0f}",
        f"{curve[-1]:,.0f}" if curve[-1] >= 100 else f"{curve[-1]:.3g}",
        "trial 1",
        f"{trials:,}",
    ]
    (line,) = ElementTree.fromstring(picture).iter(f"{SVG}polyline")
    places = [tuple(map(float, pair.split(","))) for pair in line.attrib["points"].split()]
    assert places == sorted(places)


def test_a_level_curve_is_drawn():
    assert texts(curve_picture([5.0, 5.0], 5.0))[:2] == ["5", "5"]


def test_a_ranking_shows_the_best_with_intervals_and_marks():
    points = [Ranked(f"a<b {number}", 100.0 + number, 5.0, number < 2) for number in range(30)]
    heading, *rows = texts(ranking_picture(points, "total_steps"))
    assert heading == "total_steps, the 20 best of 30, bars: 95 % of each by itself"
    assert rows[:4] == ["★ a<b 0", "100", "★ a<b 1", "101"]
    assert len(rows) == 40


@pytest.mark.parametrize("values", [(0.0, 0.0), (1.0, 1.0), (-2.0, 3.0), (1.0, 500.0), (0.0, 0.5)])
def test_any_values_are_drawn_within_the_picture(values: tuple[float, float]):
    drawn = ElementTree.fromstring(ranking_picture([Ranked("x" * 80, value, 3.0) for value in values], "measure"))
    width = float(drawn.attrib["width"])
    assert all(0 < float(circle.attrib["cx"]) < width for circle in drawn.iter(f"{SVG}circle"))
