"""Many lines and pairs: a few by name, and what all have in common."""

from __future__ import annotations

from itertools import pairwise

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest

from rl_design_space.analysis.pooling import Repetition
from rl_design_space.errors import ConfigError
from rl_design_space.learning import simulate
from rl_design_space.learning.measures import measure
from rl_design_space.plan.planner import plan_point
from rl_design_space.report import Compare, Sensitivity
from rl_design_space.report.base import MAIN
from rl_design_space.report.fitting import fit
from rl_design_space.report.markdown import Table
from rl_design_space.report.not_shown import not_shown
from rl_design_space.report.pairs import Pair, ratio_of
from rl_design_space.report.points import Point

SIZE = ("task.periods=6", "task.trials=5", "world.size=4", "exploration=linear")


def lines(count: int) -> pd.DataFrame:
    rows = [
        (f"reward=r{i} msa=m{i % 2}", k, (1 + i) * 100.0 * (1 + (i + 1) * 0.1 * k), 0.0, 0.0, 1)
        for i in range(count)
        for k in (1, 2, 3)
    ]
    return pd.DataFrame(rows, columns=["line", "k", "value", "low", "high", "runs"])


def test_sixty_lines_are_a_range_a_median_and_a_few_names():
    figure = Sensitivity(parameter="k", top=5)
    drawn = figure.draw({MAIN: lines(60)})
    (axis,) = drawn.axes
    legend = [text.get_text() for text in axis.get_legend().get_texts()]
    assert legend[:3] == ["80 % of 60 lines", "half of them", "their median"]
    assert legend[3:] == [f"reward=r{i} msa=m{i % 2}" for i in (59, 58, 57)]  # those that depend most
    assert axis.get_yscale() == "log"
    assert axis.get_ylabel().startswith("total_steps, relative to")
    plt.close(drawn)
    told, first, *_ = figure.text({MAIN: lines(60)})
    assert told == "The 5 of 60 lines that depend most; the CSV file has the others."
    assert isinstance(first, Table)
    assert len(first.frame) == 5
    named = Sensitivity(parameter="k", named="msa=m1 reward=r1", scale="linear").draw({MAIN: lines(60)})
    assert [text.get_text() for text in named.axes[0].get_legend().get_texts()][3:] == ["reward=r1 msa=m1"]
    assert named.axes[0].get_ylabel() == "total_steps"
    plt.close(named)
    with pytest.raises(ConfigError, match="named=msa=none: nothing that is shown has these values"):
        Sensitivity(parameter="k", named="msa=none").draw({MAIN: lines(60)})


def test_lines_that_are_named_are_listed_first_within_the_top():
    told, first, *_ = Sensitivity(parameter="k", top=3, named="reward=r1").text({MAIN: lines(60)})
    assert told == "3 of 60 lines, 1 by name and those that depend most; the CSV file has the others."
    assert list(first.frame["line"]) == ["reward=r1 msa=m1", "reward=r59 msa=m1", "reward=r58 msa=m0"]
    told, first, *_ = Sensitivity(parameter="k", top=1, named=("reward=r1", "reward=r2")).text({MAIN: lines(60)})
    assert told == "2 of 60 lines, 2 by name; the CSV file has the others."
    assert list(first.frame["line"]) == ["reward=r1 msa=m1", "reward=r2 msa=m0"]


def test_a_name_is_refused_where_few_lines_are_all_shown_too():
    figure = Sensitivity(parameter="k", named="msa=none")
    with pytest.raises(ConfigError, match="named=msa=none: nothing that is shown has these values"):
        figure.text({MAIN: lines(2)})


def test_a_name_that_changes_nothing_is_told():
    (note,) = Sensitivity(parameter="k", named="msa=m1").main_numbers({MAIN: lines(2)}).lines
    assert note == "named=msa=m1 changes nothing: all 2 lines are shown by name."
    assert Sensitivity(parameter="k", named="msa=m1", top=1).main_numbers({MAIN: lines(2)}).lines == ()
    (note,) = Compare(a="x=1", b="x=2", named="reward=r1").main_numbers({MAIN: pairs(3)}).lines
    assert note == "named=reward=r1 changes nothing: all 3 pairs are shown by name."
    assert Compare(a="x=1", b="x=2", named="reward=r1", top=2).main_numbers({MAIN: pairs(3)}).lines == ()


def test_a_few_lines_are_all_in_the_legend_by_name():
    drawn = Sensitivity(parameter="k").draw({MAIN: lines(2)})
    assert [text.get_text() for text in drawn.axes[0].get_legend().get_texts()] == [
        "reward=r0 msa=m0",
        "reward=r1 msa=m1",
    ]
    plt.close(drawn)


def pairs(count: int) -> pd.DataFrame:
    rows = [
        (f"reward=r{i}", 100.0, 100.0 + i, float(i), i - 1.0, i + 1.0, 5, 1 + i / 100, 0.99 + i / 100, 1.01 + i / 100)
        for i in range(count)
    ]
    frame = pd.DataFrame(
        rows, columns=["pair", "a", "b", "difference", "low", "high", "periods", "ratio", "ratio_low", "ratio_high"]
    )
    return pd.concat([frame, frame.tail(1).assign(pair="all pairs")], ignore_index=True)


def test_sixty_pairs_are_the_largest_ratios_and_where_most_lie():
    compare = Compare(a="x=1", b="x=2", top=3, named="reward=r7")
    shown = compare.shown_pairs(pairs(60))
    assert list(shown["pair"]) == ["reward=r7", "reward=r58", "reward=r59", "all pairs"]
    figure = compare.draw({MAIN: pairs(60)})
    (axis,) = figure.axes
    assert axis.get_xscale() == "log"
    assert "80 % of all 60 pairs" in [text.get_text() for text in axis.get_legend().get_texts()]
    assert axis.get_title() == "total_steps: x=2 over x=1"
    plt.close(figure)
    text = compare.text({MAIN: pairs(60)})
    assert text[0] == "3 of 60 pairs; the CSV file has the others."
    assert "ratio" in text[1].frame
    assert len(Compare(a="x=1", b="x=2", top=3).shown_pairs(pairs(3))) == 4


def test_long_names_leave_room_for_the_data():
    frame = pairs(12).assign(pair=[f"reward=reward_{i} representation=a_long_name world.size=10" for i in range(13)])
    compare = Compare(a="x=1", b="x=2", scale="ratio")
    figure = compare.draw({MAIN: frame})
    fit(figure, 3.5, None, None)
    figure.draw_without_rendering()
    (axis,) = figure.axes
    assert figure.get_size_inches()[0] == 3.5
    assert axis.get_position().width > 0.4
    boxes = [tick.get_window_extent() for tick in axis.get_yticklabels()]
    assert all(one.y0 >= other.y1 - 1 for one, other in pairwise(boxes))  # from top to bottom
    assert min(box.x0 for box in boxes) >= 0
    plt.close(figure)


def test_a_ratio_is_that_of_the_means_with_a_paired_interval():
    planned = [plan_point([*SIZE, f"representation={name}"]) for name in ("ad_hoc", "direction")]
    learned = [simulate(each.point) for each in planned]
    steps = measure("total_steps")
    pair = Pair([learned[0]], [learned[1]], Repetition("one", 0))
    found = ratio_of(steps, [pair])
    assert found["ratio"] == pytest.approx(learned[1].total_steps.mean() / learned[0].total_steps.mean())
    assert found["ratio_low"] < found["ratio"] < found["ratio_high"]
    same = ratio_of(steps, [Pair([learned[0]], [learned[0]], Repetition("one", 0))])
    assert list(same.values()) == pytest.approx([1, 1, 1])
    both = ratio_of(steps, [pair, Pair([learned[1]], [learned[0]], Repetition("two", 0))])
    assert both["ratio"] == pytest.approx(1)  # the geometric mean of a ratio and its inverse


def test_an_order_that_is_asked_for_is_that_of_the_axis():
    rows = lines(2).sort_values("k", key=lambda column: column.map([3, 1, 2].index), kind="stable")
    drawn = Sensitivity(parameter="k", order={"k": [3, 1, 2]}).draw({MAIN: rows})
    (axis,) = drawn.axes
    assert [tick.get_text() for tick in axis.get_xticklabels()] == ["3", "1", "2"]
    assert axis.get_xscale() == "linear"
    plt.close(drawn)


def test_a_line_has_a_gap_at_a_value_without_a_run():
    rows = lines(2)
    drawn = Sensitivity(parameter="k").draw({MAIN: rows[(rows["line"] != "reward=r0 msa=m0") | (rows["k"] != 2)]})
    gap, whole = (each.lines[0].get_ydata().astype(float) for each in drawn.axes[0].containers)
    assert np.isnan(gap).tolist() == [False, True, False]
    assert not np.isnan(whole).any()
    plt.close(drawn)


def test_runs_that_make_no_line_are_named_with_what_differs():
    values = [("ad_hoc", None, 1), ("distance", "all", 1), ("direction", "all", 1), ("direction", "all", 2)]
    a, *lined, lone = (Point(dict(zip(("rep", "rep.goals", "k"), each, strict=True)), None) for each in values)
    assert list(not_shown("rep", ["rep.goals", "k"], [a, lone], lined)) == [
        "Not shown: rep=ad_hoc (1 run), because no run with another rep has the same rep.goals.",
        "Not shown: 1 run, from which no other run differs in rep alone.",
    ]
    frames = {MAIN: lines(2), "_not_shown": pd.DataFrame({"note": ["Not shown: x."]})}
    figure = Sensitivity(parameter="k")
    drawn = figure.draw(frames)
    assert drawn._supxlabel.get_text() == "Not shown: x."
    assert "Not shown: x." in figure.text(frames)
    assert figure.main_numbers(frames).lines == ("Not shown: x.",)
    plt.close(drawn)
