"""Why trials fail: the tails of a small study, learned again, and the baseline of curves."""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest

from rl_design_space.analysis.endings import ENDINGS, NOT_LEARNED, NOT_REPRESENTED, OPEN
from rl_design_space.commands import figure_words
from rl_design_space.errors import ConfigError
from rl_design_space.learning import simulate
from rl_design_space.plan.study import Study, plan_overrides
from rl_design_space.report.base import MAIN, Frames
from rl_design_space.report.baselines import above_optimum, told_of_memoryless
from rl_design_space.report.failures import EXAMPLES, PERIODS, TRIALS, Failures
from rl_design_space.report.failures_examined import tail_of
from rl_design_space.report.runs import Runs
from tests.points import planning
from tests.report.readers import LearningReader
from tests.tracking.stores import copy_database, learned, record, tracker_at

#: Few steps, so that trials fail, and soon no exploration.
SWEEP = [
    *("task.periods=30", "task.trials=40", "task.max_steps=60", "task.goals=2", "world.size=6"),
    *("exploration=linear", "exploration.k=0.05", "representation=ad_hoc,direction"),
]
REPORT = Failures(tail=20, most=4)


@pytest.fixture(scope="module")
def study() -> Study:
    with planning() as planner:
        return Study("mine", (), planner.composer.config(()), plan_overrides(SWEEP, planner))


@pytest.fixture(scope="module")
def frames(study: Study) -> Frames:
    return REPORT.frames(Runs.of_study(study, LearningReader(study.plan)))


def test_the_tail_is_what_takes_most_steps():
    total = np.array([3.0, 9, 1, 7, 9, 2, 5, 4, 6, 8])
    tail, chosen = tail_of(total, 50, 3)
    assert tail.tolist() == [1, 4, 9, 3, 8]
    assert chosen.tolist() == [1, 9, 8]
    assert tail_of(total, 1, 3)[0].tolist() == [1]


def test_the_numbers_are_those_of_the_periods(frames: Frames, study: Study):
    main, periods, trials = frames[MAIN].set_index("design"), frames[PERIODS], frames[TRIALS]
    for planned in study.plan:
        name = f"representation={planned.options['representation']}"
        curves = simulate(planned.point)
        worst = np.argsort(-curves.total_steps, kind="stable")[:6]
        design, here = main.loc[name], periods[periods["design"] == name]
        assert (design["periods"], design["tail_periods"], design["examined"]) == (30, 6, 4)
        assert design["tail_share"] == pytest.approx(curves.total_steps[worst].sum() / curves.total_steps.sum())
        assert set(here["period"]) <= set(worst.tolist())
        failed = (~curves.success)[here["period"]].sum(axis=1)
        assert here["failed_trials"].tolist() == failed.tolist()
        of_design = trials[trials["design"] == name]
        assert len(of_design) == failed.sum() == design["failed_trials"] > 0
        assert (of_design["ending"].value_counts() / len(of_design)).to_dict() == pytest.approx(
            {kind: design[kind] for kind in ENDINGS if design[kind]}
        )


def test_both_representations_could_have_reached_the_goal(frames: Frames):
    assert (frames[PERIODS]["memoryless_steps"] == frames[PERIODS]["optimum"]).all()
    failing = frames[PERIODS][frames[PERIODS]["failed_trials"] > 0]
    assert set(failing["verdict"]) == {NOT_LEARNED}
    assert frames[MAIN][[NOT_REPRESENTED, OPEN]].sum().sum() == 0
    assert f"not learned {len(failing)}, cannot be represented 0, open 0" in REPORT.text(frames)[1]


def test_the_text_says_what_is_left_out(frames: Frames):
    (note,) = [part for part in REPORT.text(frames) if "evenly spaced" in part]
    assert note == (
        "8 of the 12 periods of the tails are examined, evenly spaced from the most steps to the least: "
        "at most 4 of a design."
    )
    many = pd.concat([frames[MAIN].assign(examined=6)] * 5, ignore_index=True)
    (note,) = [part for part in REPORT.text({MAIN: many}) if "The picture shows" in part]
    assert note.startswith("The picture shows the 9 of 10 designs with the most failed periods;")
    whole = REPORT.text({MAIN: frames[MAIN].assign(examined=6)})
    assert not any("evenly spaced" in part or "The picture shows" in part for part in whole)


def test_the_picture_has_a_row_for_each_design(frames: Frames):
    axes = REPORT.draw(frames).axes
    assert len(axes) == 2 * 3
    design = frames[MAIN].iloc[0]
    assert axes[1].get_xlabel().startswith(f"of {design['failed_trials']:,} failed trials, ")
    assert [round(bar.get_width(), 9) for bar in axes[1].patches] == [round(design[kind], 9) for kind in ENDINGS]
    example = frames[EXAMPLES].iloc[0]
    assert axes[2].get_xlabel().startswith(f"period {example['inside'].period}, trial {example['trial']}, to goal ")


def test_the_axis_of_a_single_period_has_its_rank_alone(frames: Frames):
    single = frames[PERIODS].groupby("design", sort=False).head(1)
    figure = REPORT.draw({**frames, PERIODS: single})
    axis = figure.axes[0]
    low, high = axis.get_xlim()
    assert (low, high) == (0.5, 1.5)
    assert [tick for tick in axis.get_xticks() if low <= tick <= high] == [1]
    assert axis.get_lines()[-1].get_xdata().tolist() == [0.5, 1, 1.5]  # the best policy
    plt.close(figure)


def test_many_designs_have_lower_rows(frames: Frames):
    few, many = (
        REPORT.draw({**frames, MAIN: pd.concat([frames[MAIN].head(1)] * number, ignore_index=True)})
        for number in (1, 5)
    )
    assert many.get_size_inches()[1] < 3 * few.get_size_inches()[1]
    assert len(many.axes) == 5 * len(few.axes)
    plt.close(few)
    plt.close(many)


def test_recorded_runs_are_examined_by_the_command(tmp_path: Path, empty_database: Path):
    copy_database(empty_database, tmp_path / "mlflow.db")
    planned, curves = learned("task.max_steps=15")
    run = record(tracker_at(tmp_path / "mlflow.db"), planned, curves)
    paths = figure_words.main("failures", ["--tail", "50", f"outputs={tmp_path}"])
    names = {path.name for path in paths}
    assert names == {f"failures{end}" for end in (".png", ".svg", ".csv", ".md", "_periods.csv", "_trials.csv")}
    periods = pd.read_csv(tmp_path / "report" / "failures_periods.csv")
    worst = np.argsort(-curves.total_steps, kind="stable")[:2]
    assert periods["period"].tolist() == worst.tolist()
    path = Path(run.artifacts.removeprefix("file://")) / "config.yaml"
    path.write_text(path.read_text().replace("max_steps: 15", "max_steps: 14"), encoding="utf-8")
    with pytest.raises(ConfigError, match="its steps are not those that this version learns"):
        figure_words.main("failures", ["--tail", "50", f"outputs={tmp_path}"])


def test_a_baseline_is_told_where_it_is_not_the_optimum():
    panels = pd.DataFrame({"panel": ["left", "right"], "optimum": [10.0, 10.0]})
    lines = pd.DataFrame(
        {"panel": ["left", "right", "right"], "line": ["a", "b", "c"], "memoryless": [10.0, 12.5, np.nan]}
    )
    assert above_optimum(lines, panels)["line"].tolist() == ["b"]
    assert told_of_memoryless(lines, panels)[0].endswith("over those of the optimum are 1.25 (b).")
    assert "as few steps as the optimum" in told_of_memoryless(lines[:1], panels)[0]
    assert told_of_memoryless(lines[2:], panels) == []
