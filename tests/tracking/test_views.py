"""Saved views: their content, and that MLflow accepts them."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any
from urllib.parse import parse_qs, urlsplit

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rl_design_space.learning.measures import CURVES, SCALARS
from rl_design_space.plan.plan import Plan, PlannedPoint
from rl_design_space.tracking.view_state import KIND, VIEW_TAG
from rl_design_space.tracking.views import link, points_tags, points_view, study_view, sweeps_tags, sweeps_view
from tests.points import planned_point, shipped_study
from tests.tracking.stores import learned, tracker_at

CREATED = 1_700_000_000_000
TEN = {"representation": {"ad_hoc": 5, "direction": 5}, "exploration.k": dict.fromkeys(map(str, range(5)), 2)}
#: The axes of the study of figure 3; the parameters of a point depend on its kind of schedule.
MANY = {
    "representation": {"ad_hoc": 36, "direction": 36},
    "exploration": {"linear": 20, "exponential": 20, "sigmoidal": 32},
    "exploration.k": dict.fromkeys(map(str, range(10)), 2),
    "exploration.l": dict.fromkeys(map(str, range(10)), 2),
}


def state_of(view: tuple[str, str]) -> dict[str, Any]:
    """Return the state of the page, as the UI reads it: JSON within JSON."""
    outer = json.loads(view[1])
    assert outer["createdAt"] == outer["updatedAt"] == CREATED
    state: dict[str, Any] = json.loads(outer["state"])
    return state


def views_of(plan: Plan) -> dict[str, dict[str, Any]]:
    tags = points_tags(plan, CREATED)
    return {tag.removeprefix(VIEW_TAG): state_of((tag, text)) for tag, text in tags.items() if tag not in KIND}


def study_state(axes: dict[str, dict[str, int]]) -> dict[str, Any]:
    return state_of(study_view("mine", axes, CREATED))


def groups_of(state: dict[str, Any]) -> list[str]:
    return [key["groupByData"] for key in (state.get("groupBy") or {"groupByKeys": []})["groupByKeys"]]


def drawn(state: dict[str, Any], kind: str) -> list[dict[str, Any]]:
    return [chart for chart in state["compareRunCharts"] if chart["type"] == kind and not chart["deleted"]]


def test_the_runs_of_a_study_are_sorted_best_first():
    key, text = study_view("mine", TEN, CREATED)
    state = state_of((key, text))
    assert (key, json.loads(text)["name"]) == ("study.mine", "mine")
    assert state["searchFilter"] == "tags.`study.mine` = 'true'"
    assert (state["orderByKey"], state["orderByAsc"]) == ("metrics.`total_steps`", True)


def test_the_columns_are_the_parameters_that_differ_and_the_scalars():
    assert study_state(TEN)["selectedColumns"] == [
        "params.`representation`",
        "params.`exploration.k`",
        "params.`task.periods`",
        "metrics.`total_steps`",
        "metrics.`failed_trials`",
        "metrics.`final_steps_over_optimum`",
    ]


def test_periods_are_one_column():
    columns = study_state({"task.periods": {"50": 1, "500": 1}})["selectedColumns"]
    assert columns.count("params.`task.periods`") == 1


def test_every_curve_is_a_chart_over_trials():
    charts = drawn(study_state(TEN), "LINE")
    assert [chart["metricKey"] for chart in charts] == list(CURVES)
    assert {chart["metricKey"]: chart["scaleType"] for chart in charts} == {
        "steps/mean": "log",
        "steps/median": "log",
        "success_rate": "linear",
    }
    assert {chart["xAxisKey"] for chart in charts} == {"step"}


def test_scalars_without_a_chart_have_a_deleted_one_so_that_the_ui_adds_none():
    charts = {chart["metricKey"]: chart for chart in study_state(TEN)["compareRunCharts"] if chart["type"] == "BAR"}
    assert set(charts) == set(SCALARS)
    assert {name for name, chart in charts.items() if not chart["deleted"]} == {
        "total_steps",
        "failed_trials",
        "final_steps_over_optimum",
    }


def test_every_chart_is_in_an_existing_section():
    state = study_state(TEN)
    sections = {section["uuid"] for section in state["compareRunSections"]}
    assert {chart["metricSectionId"] for chart in state["compareRunCharts"]} == sections
    uuids = [chart["uuid"] for chart in state["compareRunCharts"]]
    assert len(set(uuids)) == len(uuids)


def test_few_points_are_drawn_as_a_line_each():
    state = study_state(TEN)
    assert groups_of(state) == []
    assert state["runsHiddenMode"] == "SHOW_ALL"
    assert drawn(state, "PARALLEL")[0]["selectedParams"] == ["representation", "exploration.k"]


def test_many_points_are_grouped_by_the_options_that_all_of_them_have():
    state = study_state(MANY)
    assert groups_of(state) == ["representation", "exploration"]
    assert state["runsHiddenMode"] == "SHOW_ALL"
    assert drawn(state, "PARALLEL") == []


def test_points_are_not_grouped_by_an_option_and_its_values():
    lengths = {
        "msa": {"none": 12, "length_3": 12},
        "msa.lengths": {"[]": 12, "[3]": 12},
        "task.goals": {"1": 8, "2": 16},
    }
    assert groups_of(study_state(lengths)) == ["msa", "task.goals"]


def test_more_points_than_a_page_holds_are_not_averaged():
    state = study_state({"representation": {"ad_hoc": 60, "direction": 60}})
    assert groups_of(state) == []
    assert state["runsHiddenMode"] == "FIRST_20_RUNS"


COUNTS = st.dictionaries(st.text(min_size=1, max_size=5), st.integers(1, 30), min_size=2, max_size=12)
NAMES = st.sampled_from(["representation", "exploration", "msa", "msa.lengths", "world.size", "learner.alpha"])


@given(st.dictionaries(NAMES, COUNTS))
def test_groups_are_few_and_parallel_coordinates_show_all_runs(axes: dict[str, dict[str, int]]):
    state = study_state(axes)
    count = max((sum(counts.values()) for counts in axes.values()), default=1)
    groups = 1
    for name in groups_of(state):
        groups *= len(axes[name])
        assert sum(axes[name].values()) == count
    assert groups <= 12
    for chart in drawn(state, "PARALLEL"):
        assert len(chart["selectedParams"]) <= 6
        assert all(sum(axes[name].values()) == count for name in chart["selectedParams"])


def test_each_study_of_a_plan_has_the_axes_of_its_own_points():
    points = [
        replace(planned_point(["representation=ad_hoc"]), studies=("a", "b")),
        replace(planned_point(["representation=direction"]), studies=("a",)),
        replace(planned_point(["world.size=20"]), studies=("b",)),
    ]
    views = views_of(Plan(points, studies=("a", "b")))
    columns = {key: state["selectedColumns"] for key, state in views.items()}
    assert set(columns) == {"points", "study.a", "study.b"}
    assert "params.`representation`" in columns["study.a"]
    assert "params.`world.size`" not in columns["study.a"]
    assert "params.`world.size`" in columns["study.b"]
    assert "params.`representation`" not in columns["study.b"]


def test_mlflow_accepts_the_view_of_the_largest_study():
    from mlflow.utils.validation import MAX_EXPERIMENT_TAG_VAL_LENGTH

    plan = shipped_study("paper").plan
    assert len(plan) > 400
    views = points_tags(plan, CREATED)
    keys = ("points", *(f"study.{study}" for study in plan.studies))
    assert set(views) == {*KIND, *(f"{VIEW_TAG}{key}" for key in keys)}
    assert max(map(len, views.values())) < MAX_EXPERIMENT_TAG_VAL_LENGTH


def test_mlflow_accepts_the_view_of_a_study_of_all_parameters():
    from mlflow.utils.validation import MAX_EXPERIMENT_TAG_VAL_LENGTH

    names = [name for option in ("linear", "sigmoidal") for name in planned_point([f"exploration={option}"]).parameters]
    assert len(names) > 50
    _, text = study_view("all", {name: dict.fromkeys(map(str, range(10_000)), 1) for name in names}, CREATED)
    assert len(text) < MAX_EXPERIMENT_TAG_VAL_LENGTH


def test_a_shard_has_the_view_of_the_whole_plan():
    one = planned_point([])
    points = [
        PlannedPoint.of(replace(one.point, seed=seed), one.options, (f"seed={seed}",), ("a",)) for seed in range(120)
    ]
    whole = Plan(points, studies=("a",))
    # Too many points for a line each, unlike those of the shard.
    assert views_of(whole)["study.a"]["runsHiddenMode"] == "FIRST_20_RUNS"
    assert views_of(Plan(whole[:15], studies=("a",)))["study.a"]["runsHiddenMode"] == "SHOW_ALL"
    assert views_of(whole.shard(2, of=8)) == views_of(whole)


def test_a_sweep_saves_its_views_in_the_experiments(database: Path):
    from mlflow import MlflowClient

    planned, _ = learned()
    plan = Plan([replace(planned, studies=("mine",))], studies=("mine",))
    tracker_at(database).open_sweep(plan, "rl-design-space study=mine")
    client = MlflowClient(f"sqlite:///{database}")

    points, sweeps = (client.get_experiment_by_name(name).tags for name in ("design points", "sweeps"))
    created = json.loads(points[f"{VIEW_TAG}points"])["createdAt"]
    assert f"{VIEW_TAG}study.mine" in points
    assert points.items() >= points_tags(plan, created).items()
    assert sweeps.items() >= sweeps_tags(created).items()


@pytest.mark.parametrize(
    ("view", "key", "name"),
    [
        (points_view(CREATED), "points", "all design points"),
        (sweeps_view(CREATED), "sweeps", "all sweeps"),
    ],
)
def test_views_of_all_runs_show_the_latest_first(view: tuple[str, str], key: str, name: str):
    state = state_of(view)
    assert (view[0], json.loads(view[1])["name"]) == (key, name)
    assert state["searchFilter"] == ""
    assert (state["orderByKey"], state["orderByAsc"]) == ("attributes.start_time", False)


def test_a_link_opens_a_view_as_table_or_as_charts():
    address = urlsplit(link("http://127.0.0.1:5000/", "7", "study.my study"))
    path, _, query = address.fragment.partition("?")
    assert (address.netloc, address.path, path) == ("127.0.0.1:5000", "/", "/experiments/7/runs")
    assert parse_qs(query) == {"viewStateShareKey": ["study.my study"], "workflowType": ["machine_learning"]}
    assert "compareRunsMode=CHART" in link("http://a", "7", "points", charts=True)
    assert "viewStateShareKey" not in link("http://a", "7")
