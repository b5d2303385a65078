"""Reports of what transfers: sizes, layouts, and what coarse grids cost, each against tables computed by hand."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from rl_design_space.config.compose import shipped_config
from rl_design_space.learning import LearningCurves, simulate
from rl_design_space.plan.plan import Plan
from rl_design_space.plan.planner import Planner
from rl_design_space.plan.study import Study, load_study, plan_overrides
from rl_design_space.report import StageCosts, TransferCurve, TransferMap
from rl_design_space.report.base import MAIN
from rl_design_space.report.runs import Runs
from tests.report.readers import LearningReader

TINY = ["task.periods=12", "task.trials=5", "task.goals=2", "task.max_steps=60"]
COARSE = ["curriculum=coarse_to_fine", "curriculum.trials=4"]


def runs_of(*sweeps: list[str], missing: tuple[str, ...] = ()) -> Runs:
    with shipped_config():
        planner = Planner()
        points = [planned for sweep in sweeps for planned in plan_overrides([*TINY, *sweep], planner)]
        study = Study("mine", (), planner.composer.config(()), Plan(points))
    return Runs.of_study(study, LearningReader(study.plan, missing))


def result(runs: Runs, **where: object) -> LearningCurves:
    return simulate(runs.one({name.replace("__", "."): value for name, value in where.items()}).planned.point)


@pytest.fixture(scope="module")
def sizes() -> Runs:
    used = [*COARSE, "world.size=3,4", "curriculum.zero_shot=2", "curriculum.epsilon=0.1"]
    carried = [*used, "curriculum.sizes=[3],[4]", "curriculum.carry=same_place"]
    return runs_of(carried, [*used, "curriculum.sizes=[3]", "curriculum.carry=none"])


def test_steps_saved_are_those_of_the_last_stage_against_beginning_with_nothing(sizes: Runs):
    report = TransferMap(
        title="Saved", value="total_steps,stage=last", saved=True, nothing={"curriculum.carry": "none"},
        named=((4, 3),),
    )  # fmt: skip
    frames = report.frames(sizes)
    cells = frames[""].set_index(["source", "target"])
    assert sorted(cells.index) == [(3, 3), (3, 4), (4, 3), (4, 4)]
    one = result(sizes, curriculum__sizes=[4], world__size=3)
    nothing = result(sizes, curriculum__carry="none", world__size=3)
    saved = 1 - one.stage(3).total_steps.mean() / nothing.stage(3).total_steps.mean()
    assert cells.loc[(4, 3), "value"] == pytest.approx(saved)
    assert (cells["low"] <= cells["value"]).all()
    assert (cells["value"] <= cells["high"]).all()
    (line,) = report.numbers(frames)
    assert line.startswith(f"ad hoc, same place, constant: 4 → 3: {saved:.0%} (")
    assert len(report.draw(frames).axes) == 2  # a panel and the scale


def test_a_share_that_is_rounded_to_zero_has_no_sign():
    report = TransferMap(title="Saved", value="total_steps", saved=True, nothing={"curriculum.carry": "none"})
    cell = {"exploration": "constant", "curriculum.carry": "same_place", "representation": "ad_hoc", "runs": 1}
    numbers = {"value": -0.001, "low": -0.01, "high": -0.002, "median": -0.004}
    frames = {MAIN: pd.DataFrame([{**cell, "source": 10, "target": 30, **numbers}])}
    assert report.numbers(frames) == [
        "ad hoc, same place, constant: 10 → 30: 0% (-1% – 0%), smaller to larger 0% to 0%"
    ]
    assert "-0%" not in report.text(frames)[-1]
    assert "-0%" not in {text.get_text() for text in report.draw(frames).axes[0].texts}


def test_zero_shot_shares_stand_beside_those_of_a_q_matrix_that_knows_nothing(sizes: Runs):
    report = TransferMap(title="Solved", value="solved_within=2,stage=2", nothing={"curriculum.carry": "none"})
    cells = report.frames(sizes)[""].set_index(["source", "target"])
    assert set(cells.index) == {(3, 3), (3, 4), (4, 3), (4, 4), ("nothing", 3), ("nothing", 4)}
    one = result(sizes, curriculum__sizes=[4], world__size=4).stage(2)
    near = one.success & (one.steps <= 2 * one.optimum[:, np.newaxis])
    assert cells.loc[(4, 4), "value"] == pytest.approx(near.mean())
    assert cells.loc[(4, 4), "value"] > cells.loc[("nothing", 4), "value"]


def test_a_cell_without_a_run_is_hatched_and_counted(tmp_path: Path):
    used = [*COARSE, "world.size=3", "curriculum.zero_shot=2", "curriculum.sizes=[3]"]
    runs = runs_of([*used, "curriculum.carry=same_place,none"])
    runs = runs_of([*used, "curriculum.carry=same_place,none"], missing=(runs.points[0].planned.fingerprint,))
    report = TransferMap(title="Solved", value="solved,stage=2", nothing={"curriculum.carry": "none"})
    report.write_runs(runs, tmp_path / "mine")
    assert "Hatched: 1 of 2 cells are missing." in (tmp_path / "mine.md").read_text(encoding="utf-8")
    assert pd.read_csv(tmp_path / "mine.csv")["value"].isna().tolist() == [True, False]


def test_a_curve_says_after_how_many_layouts_new_ones_are_solved_at_once():
    new = ["world.size=4", "curriculum=new_goals", "curriculum.layouts=4", "curriculum.zero_shot=2"]
    runs = runs_of([*new, "curriculum.carry=same_observation,none", "representation=direction"])
    carried, nothing = ({"curriculum.carry": carry} for carry in ("same_observation", "none"))
    report = TransferCurve(
        title="New layouts", lines={"direction": carried, "again": carried}, nothing={"direction": nothing},
        at_once=3.0, level=0.01, grades={"direction": "+", "again": "++"},
    )  # fmt: skip
    frames = report.frames(runs)
    rows = frames[""].set_index(["line", "layouts"])
    assert rows.loc["direction"].index.tolist() == [1, 2, 3]
    one, other = (result(runs, curriculum__carry=carry) for carry in ("same_observation", "none"))
    used = one.stage(4)  # after two layouts: learned, used, learned, used
    near = used.success & (used.steps <= 3 * used.optimum[:, np.newaxis])
    assert rows.loc[("direction", 2), "at_once"] == pytest.approx(near.mean())
    saved = 1 - one.stage(5).total_steps.mean() / other.stage(5).total_steps.mean()
    assert rows.loc[("direction", 2), "saved"] == pytest.approx(saved)
    first, *_, last = report.numbers(frames)
    assert "at once in 1% of trials after 1 layouts (1 to " in first
    assert last.startswith("direction, from scratch: ")
    assert "Order not confirmed, as intervals overlap." in "\n".join(report.text(frames))
    assert len(report.draw(frames).axes) == 3


def test_coarse_grids_cost_their_steps_in_both_ways_of_counting():
    exploration = ["exploration=constant", "world.size=6"]
    staged = [*COARSE, *exploration, "curriculum.sizes=[3]", "curriculum.trials=4,5", "curriculum.epsilon=0.1"]
    runs = runs_of(exploration, staged)
    report = StageCosts(title="Costs", usual={"exploration": "constant"}, drawn=4)
    frames = report.frames(runs)
    rows = frames[""].set_index("trials")
    alone, one = result(runs, curriculum="none"), result(runs, curriculum__trials=4)
    coarse, fine = one.stage(1).total_steps, one.stage(2).total_steps
    assert rows.loc[4, "equal"] == pytest.approx((2 * coarse + fine).mean() / alone.total_steps.mean())
    assert rows.loc[4, "decisions"] == pytest.approx((coarse + fine).mean() / alone.total_steps.mean())
    assert rows.loc[4, "steps"] == pytest.approx((2 * coarse + fine).mean())
    assert rows.loc[4, "equal_usual"] == rows.loc[4, "equal"]
    assert rows.loc[4, "pays"] == (rows.loc[4, "equal_high"] < 1)
    assert rows.loc[4, "grids"] == "3 → 6"
    head, line = report.numbers(frames)
    assert head.endswith("of 2 ways to begin on coarse grids pay")
    assert line.startswith("ad hoc, constant, 3 → 6, same place: ")
    assert len(report.draw(frames).axes) == 1


@pytest.mark.parametrize("name", ["transfer_size", "transfer_goals", "coarse_to_fine"])
def test_shipped_studies_have_their_reports(name: str):
    with shipped_config():
        study = load_study(name, ("task.periods=2",))
    assert study.report()
    assert {planned.point.task.periods for planned in study.plan} == {2}
