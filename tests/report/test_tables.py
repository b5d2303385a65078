"""Tables 1, 2 and 3 and Figure 1: numbers, grades, published values and missing points."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest

from rl_design_space.analysis.quality import Quality
from rl_design_space.analysis.statistics import Estimate
from rl_design_space.design import DesignPoint, Distance, Task, Torus, cell_count
from rl_design_space.errors import ConfigError
from rl_design_space.plan.plan import Plan, PlannedPoint
from rl_design_space.plan.study import Study
from rl_design_space.report.base import MAIN
from rl_design_space.report.graded_table import DEFINITIONS, Measured
from rl_design_space.report.grading import GRADES, Grading
from rl_design_space.report.property_map import PropertyMap
from rl_design_space.report.quality_map import QualityMap, as_measured, schedule_names
from rl_design_space.report.runs import Runs
from rl_design_space.report.scenario import Scenario
from rl_design_space.report.state_space import StateSpace
from tests.points import shipped_study
from tests.report.readers import LearningReader, unpadded

#: Tables 1 and 3 of the paper: situation information, aliasing, implementability, size, generalisation; speed, quality,
#: need for exploration.
TABLE_1 = {"ad_hoc": "++ 0 − ++ 0", "distance": "+ + 0 0 +", "direction": "0 ++ + ++ ++"}
TABLE_3 = {"ad_hoc": "++ ++ +", "distance": "0 0 ++", "direction": "++ ++ ++"}
#: Table 2 of the paper, n = 1 to 5.
TABLE_2 = {
    ("ad_hoc", 10): (100, 200, 300, 400, 500),
    ("ad_hoc", 20): (400, 800, 1200, 1600, 2000),
    ("distance", 10): (10, 200, 3000, 40_000, 500_000),
    ("distance", 20): (20, 800, 24_000, 640_000, 16_000_000),
    ("direction", 10): (5, 50, 375, 2500, 15_625),
    ("direction", 20): (5, 50, 375, 2500, 15_625),
}


def shipped(name: str, *overrides: str) -> Study:
    return shipped_study(name, *overrides)


# Grades.


@pytest.mark.parametrize(("number", "grade"), [(1.0, "++"), (1.25, "++"), (1.3, "+"), (3.9, "0"), (4.1, "−")])
def test_a_small_number_is_a_good_grade(number: float, grade: str):
    assert Grading(means="-", limits=(1.25, 2.0, 4.0)).grade(number) == grade
    assert Grading(means="-", limits=(1.25, 2.0, 4.0), of_least=True).grade(10 * number, least=10) == grade


@pytest.mark.parametrize(("number", "grade"), [(5.0, "++"), (4.0, "++"), (2.0, "+"), (1.3, "0"), (1.0, "−")])
def test_a_large_number_is_a_high_grade_where_much_is_meant(number: float, grade: str):
    assert Grading(means="-", limits=(4.0, 2.0, 1.25), larger=True).grade(number) == grade


def test_the_rule_of_a_grade_is_written_out():
    assert Grading(means="-", limits=(4.0, 2.0, 1.25), larger=True, of_least=True).rule() == (
        "++ ≥ 4 × the least, + ≥ 2 × the least, 0 ≥ 1.25 × the least, otherwise −"
    )


def test_the_csv_says_what_the_cells_do():
    table = replace(
        shipped("table3").report(),
        gradings={"speed": {"means": "-", "limits": [1.0, 5.0, 9.0]}},
        paper={"ad_hoc": {"speed": "++"}},
    )
    frames = {MAIN: table.graded({"ad_hoc": {"speed": Measured(3.0, "3\n(2 – 4)", 2.0, 4.0)}})}
    (row,) = table.csv(frames)[MAIN].to_dict("records")
    assert row == {
        "row": "ad_hoc", "column": "speed", "number": 3.0, "grade": "+", "paper": "++", "measured": "3 (2 – 4)",
        "definition": "registered", "under": "", "low": 2.0, "high": 4.0, "order": "",
    }  # fmt: skip


def test_gradings_without_a_quantity_take_them_in_order():
    for name in ("table1", "table3"):
        table = shipped(name).report()
        bare = {
            column: {key: value for key, value in node.items() if key != "of"}
            for column, node in table.gradings.items()
        }
        assert replace(table, gradings=bare).built_gradings() == table.built_gradings()


def test_a_quantity_that_is_not_measured_is_refused():
    table = shipped("table3").report()
    gradings = {"speed": {"means": "-", "limits": [1.0, 5.0, 9.0], "of": "sped"}}
    with pytest.raises(ConfigError, match=r"of=sped: no such quantity; did you mean .*of=speed\?"):
        replace(table, gradings=gradings).built_gradings()


# Table 1.


def test_table_1_has_the_papers_grades_and_ours_where_they_can_be_measured():
    table: PropertyMap = shipped("table1").report()
    assert {row: " ".join(grades.values()) for row, grades in table.paper.items()} == TABLE_1
    frames = replace(table, layouts=5, larger=12).frames(Runs([], LearningReader([])))
    cells = frames[MAIN].set_index(["row", "column"])
    assert len(cells) == 15
    for row, column in cells.index:
        assert (cells.loc[(row, column), "grade"] in GRADES) == (column != "implementability"), (row, column)
    assert cells.loc[("ad_hoc", "perceptual aliasing"), "number"] == 0
    assert cells.loc[("distance", "perceptual aliasing"), "number"] > 0
    assert cells.loc[("direction", "size of state space"), "measured"] == "375 observations"
    assert cells.loc[("ad_hoc", "implementability"), "measured"] == "judged by the paper"
    others = frames[DEFINITIONS].drop_duplicates(["column", "definition", "under"])
    orders = others[others["column"] == "perceptual aliasing"].set_index(["definition", "under"])["order"].to_dict()
    for under in ("all goals", "remaining goals"):
        assert orders.pop(("registered", under)) == "no limits"
    assert orders.pop(("registered", "")) == "no limits"
    assert len(orders) == 3 * 2
    assert set(orders.values()) == {"some limits"}


def test_table_1_is_written_without_any_run(tmp_path: Path):
    study = shipped("table1")
    paths = replace(study.report(), layouts=3, larger=11).write(study, LearningReader(study.plan), tmp_path)
    assert {path.name for path in paths} == {f"table1.{suffix}" for suffix in ("png", "svg", "csv", "md")}
    text = (tmp_path / "table1.md").read_text(encoding="utf-8")
    assert "which needs no runs" in text
    assert "judged by the paper; paper −" in text


# Table 2.


def test_table_2_has_the_papers_numbers():
    table: StateSpace = shipped("table2").report()
    published = {
        (name, size): tuple(by_goals[n] for n in range(1, 6))
        for name, sizes in table.published.items()
        for size, by_goals in sizes.items()
    }
    assert published == TABLE_2


def test_table_2_counts_rows(tmp_path: Path):
    study = shipped(
        "table2", "task.periods=4", "task.trials=3", "task.max_steps=200", "task.goals=1,2", "world.size=10"
    )
    missing = study.plan[-1]
    reader = LearningReader(study.plan, {missing.fingerprint})
    frame = study.report().frames(Runs.of_study(study, reader))[MAIN].set_index(["representation", "goals"])
    assert (frame["paper"] == frame["formula"]).all()
    assert frame.loc[("ad_hoc", 2), "met"] == 200
    assert 0 < frame.loc[("ad_hoc", 2), "learned"] <= 200
    assert frame.loc[("distance", 1), "met"] == 11  # 0 to 10
    assert np.isnan(frame.loc[(missing.options["representation"], missing.point.task.goals), "met"])
    study.report().write(study, reader, tmp_path)
    text = (tmp_path / "table2.md").read_text(encoding="utf-8")
    assert "The published formula gives 6 of the 6 published numbers." in text
    assert "**Missing: 1 of 6 points**" in text
    assert len(pd.read_csv(tmp_path / "table2.csv")) == 6


# Table 3.


def made_up(speed: float, over: float, exploration: float) -> Quality:
    sure = [Estimate(value, value, value) for value in (speed, over, 0.1, exploration)]
    return Quality("linear, k = 0.03", *sure)


def grades(table: QualityMap, **measured: Quality) -> dict[tuple[str, str], str]:
    found = {row: as_measured(measured[row]) if row in measured else {} for row in table.rows}
    return {(cell.row, cell.column): cell.grade for cell in table.graded(found).itertuples()}


def test_table_3_has_the_papers_grades():
    table: QualityMap = shipped("table3").report()
    assert {row: " ".join(grades.values()) for row, grades in table.paper.items()} == TABLE_3


def test_a_grade_turns_with_the_number():
    table: QualityMap = shipped("table3").report()
    good, bad = made_up(10, 1.01, 1.0), made_up(50, 1.6, 9.0)
    found = grades(table, ad_hoc=good, distance=bad, direction=good)
    assert [found["ad_hoc", column] for column in table.gradings] == ["++", "++", "−"]
    assert [found["distance", column] for column in table.gradings] == ["−", "−", "++"]
    turned = grades(table, ad_hoc=bad, distance=good, direction=good)
    assert [turned["ad_hoc", column] for column in table.gradings] == ["−", "−", "++"]


def test_a_row_with_a_missing_point_has_no_grade():
    table: QualityMap = shipped("table3").report()
    found = grades(table, ad_hoc=made_up(10, 1.0, 1.0))
    assert found["distance", "convergence speed"] == ""
    assert found["ad_hoc", "convergence speed"] == "++"


def test_table_3_from_points_to_files(tmp_path: Path):
    small = ("task.periods=6", "task.trials=12", "world.size=4")
    study = shipped("table3", *small)
    missing = next(p for p in study.plan if p.point.representation == Distance(goals="all"))
    reader = LearningReader(study.plan, {missing.fingerprint})
    paths = study.report().write(study, reader, tmp_path)
    assert {path.name for path in paths} == {f"table3.{suffix}" for suffix in ("png", "svg", "csv", "md")}
    written = pd.read_csv(tmp_path / "table3.csv", keep_default_na=False)
    frame = written[written["definition"] == "registered"]
    assert frame[frame["row"] == "distance"]["measured"].tolist() == ["missing"] * 3
    assert (frame[frame["row"] != "distance"]["grade"] != "").all()
    others = written[written["under"] == "remaining goals, best by total_steps"]
    assert (others["grade"] != "").all()
    assert len(others) == 3 * 9
    # There are fewer trials than this measure skips.
    assert set(written.loc[written["under"].str.contains("steps_after"), "measured"]) == {"missing"}
    text = (tmp_path / "table3.md").read_text(encoding="utf-8")
    assert "**Missing: 1 of 100 points**; `rl-design-space study=table3" in text
    study.report().write(study, LearningReader(study.plan, {p.fingerprint for p in study.plan}), tmp_path / "nothing")


@pytest.mark.parametrize("options", [["linear"], ["linear", "exponential"]])
def test_names_of_schedules_show_what_varies(options: list[str]):
    points = [{"exploration": o, "exploration.k": k, "exploration.start": 0.9} for o in options for k in (0.02, 0.5)]
    assert schedule_names(points) == [f"{o}, k = {k}" for o in options for k in (0.02, 0.5)]


# Figure 1.


def test_figure_1_sees_what_the_paper_says():
    figure: Scenario = shipped("fig1").report()
    seen = figure.seen().set_index("representation")["sees"].to_dict()
    assert seen == {"ad hoc": "(3, 3)", "distance": "(3, 3, 2)", "direction": "(right, below, left)"}


@pytest.mark.parametrize(
    ("goal", "direction"),
    [((3, 3), "here"), ((4, 3), "right"), ((2, 3), "left"), ((3, 2), "above"), ((3, 4), "below")],
)
def test_figure_1_takes_its_directions_from_the_representation(goal: tuple[int, int], direction: str):
    figure = Scenario(title="-", size=8, agent=(3, 3), goals=(goal,))
    assert figure.seen()["sees"].tolist()[-1] == f"({direction})"


def test_figure_1_is_written_without_any_run(tmp_path: Path):
    study = shipped("fig1")
    paths = study.report().write(study, LearningReader(study.plan), tmp_path)
    assert {path.name for path in paths} == {f"fig1.{suffix}" for suffix in ("png", "svg", "csv", "md")}


def test_a_goal_outside_of_the_grid_is_refused():
    with pytest.raises(ConfigError, match=r"\(9, 1\) lies outside of a grid of 8×8"):
        Scenario(title="-", size=8, agent=(3, 3), goals=((9, 1),)).seen()


# Representations of a user's own.


@dataclass(frozen=True)
class Blind:
    """Sees nothing but how many goals were reached."""

    def observation(self, world, goals):
        n_goals = goals.shape[-1]
        codes = np.arange(n_goals)[:, np.newaxis] + np.zeros(cell_count(world), int)
        return np.broadcast_to(codes, (*goals.shape, cell_count(world))).astype(np.int64)


def test_properties_of_a_representation_without_a_size_need_no_published_grades():
    limits = {"limits": [1.0, 2.0, 3.0], "means": "-"}
    columns = {"aliasing": {"of": "aliased", **limits}, "size": {"of": "observations", **limits}}
    table = PropertyMap(
        title="-", representations={"blind": Blind()}, size=4, larger=5, goals=3, layouts=4, gradings=columns
    )
    frame = table.frames(Runs([], LearningReader(Plan([]))))[MAIN].set_index("column")
    assert frame.loc["size", "number"] == 3
    assert frame.loc["size", "measured"] == "3 observations\nin 4 layouts"
    assert frame["paper"].eq("").all()
    plt.close(table.draw({MAIN: frame.reset_index()}))
    assert "blind" in table.text({MAIN: frame.reset_index()})[0]
    with pytest.raises(ConfigError, match=r"study\.report\.representations\.blind=str: should be a representation"):
        replace(table, representations={"blind": "seen"}).frames(Runs([], LearningReader(Plan([]))))


def test_a_state_space_without_a_size_has_its_rows_met_and_learned():
    point = DesignPoint(representation=Blind(), task=Task(goals=3, trials=3, periods=2), world=Torus(size=4))
    plan = Plan([PlannedPoint.of(point, {"representation": "blind"})])
    table = StateSpace(title="-")
    frames = table.frames(Runs.of_study(Study("mine", (), None, plan), LearningReader(plan)))
    (row,) = frames[MAIN].to_dict("records")
    assert (row["paper"], row["formula"], row["spanned"]) == (None, None, None)
    assert row["met"] == 3
    assert "| blind | 4×4 | 3 | – | – | 3.0 |" in unpadded(table.text(frames)[0])
    plt.close(table.draw(frames))
