"""Pictures of designs that differ in so many choices that their names leave no room."""

from __future__ import annotations

from itertools import product

import matplotlib.pyplot as plt
import pandas as pd
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from rl_design_space.report import Best, Interactions, Profile, Sensitivity
from rl_design_space.report.base import MAIN
from rl_design_space.report.fitting import fit
from rl_design_space.report.many import apart
from rl_design_space.report.profile import IMPROVEMENT

SAME = {f"learner.a_rather_long_name_{place}": "usual" for place in range(6)}
DESIGNS = [
    {**SAME, "exploration": kind, "representation": name, **{f"learner.another_name_{place}": i for place in range(4)}}
    for i, (kind, name) in enumerate(product(("linear", "exponential"), ("ad_hoc", "direction", "distance")))
]
NAMES = [" ".join(f"{key}={value}" for key, value in design.items()) for design in DESIGNS]


def test_what_long_names_share_is_said_once():
    shorter, note = apart(NAMES)
    assert note == f"In common: {' '.join(f'{key}=usual' for key in SAME)}"
    assert [name.split() for name in shorter] == [name.split()[len(SAME) :] for name in NAMES]
    assert max(len(line) for name in shorter for line in name.split("\n")) <= 90


@pytest.mark.parametrize("names", [["representation=ad_hoc", "representation=direction"], [], [""]])
def test_short_names_stay_as_they_are(names: list[str]):
    assert apart(names) == (names, "")


def test_one_long_name_has_nothing_in_common_with_others():
    (name,), note = apart(NAMES[:1])
    assert (name.split(), note) == (NAMES[0].split(), "")


def best() -> Figure:
    found = {"value": 3.0, "low": 2.0, "high": 4.0, "in_best_set": True, "loss_at_most": 0.1, "periods_to_decide": 9.0}
    return Best().draw({MAIN: pd.DataFrame([{**each, **found, "probability_best": 0.2} for each in DESIGNS])})


def test_designs_of_the_set_that_are_not_drawn_are_counted():
    found = {"value": 3.0, "low": 2.0, "high": 4.0, "loss_at_most": 0.1, "periods_to_decide": 9.0}
    rows = [{"k": k, **found, "in_best_set": k != 1, "probability_best": 0.0} for k in range(53)]
    frames = {MAIN: pd.DataFrame(rows), "_about": pd.DataFrame([{"periods": 5, "note": ""}])}
    figure = Best().draw(frames)
    assert figure.get_suptitle().endswith("(the first 30 of 53; 23 more ★ are not drawn)")
    plt.close(figure)
    assert "The 3 designs after these, 3 of them ★, are in the CSV file." in Best().text(frames)[0]


def profile(width: str | None = None) -> Figure:
    lines = [
        {"design": name, "steps_over_optimum": level, "share": level / 9, "low": level / 9, "high": level / 9}
        for name, level in product(NAMES, (1.0, 2.0, 9.0))
    ]
    pairs = [{"a": a, "b": b, "probability": 0.5, "low": 0.4, "high": 0.6} for a in NAMES for b in NAMES if a != b]
    look = {"width": width} if width else {}
    return Profile(**look).draw({MAIN: pd.DataFrame(lines), IMPROVEMENT: pd.DataFrame(pairs)})


def test_intervals_of_a_profile_are_within_their_cells():
    names = [f"exploration.k={place}" for place in range(8)]
    lines = pd.DataFrame(
        {"design": name, "steps_over_optimum": level, "share": 0.5, "low": 0.4, "high": 0.6}
        for name, level in product(names, (1.0, 9.0))
    )
    pairs = pd.DataFrame(
        {"a": a, "b": b, "probability": 1, "low": 1, "high": 1} for a, b in product(names, names) if a != b
    )
    figure = Profile().draw({MAIN: lines, IMPROVEMENT: pairs})
    FigureCanvasAgg(figure).draw()
    curves, matrix = figure.axes
    room = matrix.get_window_extent()
    assert max(text.get_window_extent().width for text in matrix.texts) < room.width / 8
    assert room.height > 1.2 * curves.get_window_extent().height  # it is beside the legend, too
    assert room.x0 - curves.get_window_extent().x1 < 0.1 * figure.bbox.width
    plt.close(figure)


def sensitivity() -> Figure:
    values = [
        {"line": name, "exploration.k": k, "value": 2.0, "low": 1.0, "high": 3.0}
        for name, k in product(NAMES, (0.1, 0.2))
    ]
    return Sensitivity(parameter="exploration.k").draw({MAIN: pd.DataFrame(values)})


def interactions() -> Figure:
    row = {"difference": 0.1, "low": 0.0, "high": 0.2, "interaction": 0.0}
    pairs = [{"pair": "msa × learner", "value": "msa=length_3", "reference": "msa=none", "at": n, **row} for n in NAMES]
    return Interactions().draw({MAIN: pd.DataFrame(pairs)})


@pytest.mark.parametrize("draw", [best, profile, sensitivity, interactions])
def test_the_data_have_room_beside_long_names(draw):
    figure = draw()
    fit(figure, None, None, None)
    FigureCanvasAgg(figure).draw()  # warns where nothing is left for the axes
    place = figure.axes[0].get_window_extent()
    assert min(place.width, place.height) > 150
    inside = figure.get_tightbbox()
    assert inside.x0 > -0.1
    assert inside.x1 < figure.get_size_inches()[0] + 0.1


def test_a_profile_that_is_one_column_wide_has_its_panels_one_above_the_other():
    figure = profile("column")
    fit(figure, 3.5, None, None)
    FigureCanvasAgg(figure).draw()
    above, below = (axis.get_window_extent() for axis in figure.axes[:2])
    assert above.y0 > below.y1
    assert min(above.width, above.height, below.width) > 100
