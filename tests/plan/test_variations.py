"""Variations: readings that change the points of a study, singly and combined."""

from __future__ import annotations

import time
from collections.abc import Mapping
from typing import Any

import pytest
from omegaconf import OmegaConf

from rl_design_space.config.compose import Composer
from rl_design_space.errors import ConfigError
from rl_design_space.plan.plan import Plan
from rl_design_space.plan.planner import Planner
from rl_design_space.plan.study import plan_study
from rl_design_space.plan.variations import Variations
from rl_design_space.plan.varied import INAPPLICABLE

READINGS = {
    "as decided": {},
    "any": {"learner.explore": "all"},
    "first": {"learner.ties": "first"},
    "walls": {"world": "walled"},
    "horizontal": {"representation.rule": "horizontal_first"},
    "slow": {"learner.alpha": 0.05},
    "fast": {"learner.alpha": 0.2},
}
BLOCKS = {"a": {"representation": "ad_hoc,direction", "world.size": 4, "task.periods": 20}}


def names(plan: Plan) -> list[str]:
    return [planned.name for planned in plan]


def of(readings: Mapping[str, Any], **more: Any) -> dict[str, Any]:
    return {"variations": {"readings": {name: READINGS[name] for name in readings}, **more}}


def test_combinations_change_different_keys_and_come_once():
    found = Variations(readings=READINGS, order=2, around=[["any", "walls"]]).combinations
    assert [each.name for each in found[:7]] == list(READINGS)
    assert "slow + fast" not in {each.name for each in found}
    assert not any("as decided" in each.readings for each in found[1:])
    triples = [each.readings for each in found if len(each.readings) == 3]
    # In the order of the readings, whichever they were added to.
    assert triples == [("any", "first", "walls")] + [
        ("any", "walls", other) for other in ("horizontal", "slow", "fast")
    ]
    assert len(found) == len({each.readings for each in found}) == 7 + (6 * 5 // 2 - 1) + 4
    assert found[-1].values == {"learner.explore": "all", "world": "walled", "learner.alpha": 0.2}


def test_single_combinations_may_be_listed():
    found = Variations(readings=READINGS, also=[["walls", "any", "slow"], ["any"]]).combinations
    assert [each.readings for each in found[len(READINGS) :]] == [("any", "walls", "slow")]


def test_each_reading_changes_each_point_that_has_its_keys(planned):
    plan = planned(BLOCKS, **of(["any", "horizontal"], order=2))
    base = [
        "representation=ad_hoc world.size=4 task.periods=20",
        "representation=direction world.size=4 task.periods=20",
    ]
    horizontal = "representation.rule=horizontal_first"
    assert names(plan) == [
        *base,
        f"{base[0]} learner.explore=all",
        f"{base[1]} learner.explore=all",
        f"{base[1]} {horizontal}",
        f"{base[1]} learner.explore=all {horizontal}",
    ]
    assert (plan.combinations, plan.duplicates) == (8, 0)
    assert [(each.constraint, each.why, each.count) for each in plan.dropped] == [("variations", INAPPLICABLE, 2)]


def test_a_reading_replaces_the_values_of_a_point_and_its_command_describes_it(planned, planner: Planner):
    plan = planned({"a": {"learner.alpha": 0.4, "world": "torus"}}, **of(["walls", "slow"], order=2))
    assert names(plan)[1:] == [
        "learner.alpha=0.4 world=walled",
        "learner.alpha=0.05 world=torus",
        "learner.alpha=0.05 world=walled",
    ]
    for point in plan:
        assert planner(point.overrides).fingerprint == point.fingerprint


def test_values_that_another_option_does_not_have_are_left_out(planned):
    sweeps = {"a": {"exploration": "linear", "exploration.k": 0.02, "exploration.start": 0.8}}
    readings = {"constant": {"exploration": "constant"}, "from 1": {"exploration.first_trial": 1}}
    found = planned(sweeps, variations={"readings": readings, "order": 2})
    assert names(found) == [
        "exploration=linear exploration.k=0.02 exploration.start=0.8",
        "exploration=constant",
        "exploration=linear exploration.k=0.02 exploration.start=0.8 exploration.first_trial=1",
    ]


def test_a_reading_that_makes_no_difference_is_no_point_of_its_own(planned):
    plan = planned({"a": {"learner.ties": "first", "task.periods": 20}}, **of(["first", "any"], order=2))
    assert len(plan) == 2
    assert plan.duplicates == 2


def test_values_apply_to_every_changed_point(planned):
    plan = planned(BLOCKS, **of(["any"], values={"task.periods": 5}))
    assert [planned.point.task.periods for planned in plan] == [20, 20, 5, 5]


def test_the_command_line_wins(planned):
    plan = planned(BLOCKS, "learner.alpha=0.3", "task.periods=7", **of(["slow", "any"], order=2, values={"seed": 3}))
    assert {point.point.learner.alpha for point in plan} == {0.3}
    assert {point.point.task.periods for point in plan} == {7}
    assert {point.point.seed for point in plan if point.point.learner.explore == "all"} == {3}
    # A study narrowed to points without the keys of a reading is no error.
    assert len(planned(BLOCKS, "representation=ad_hoc", **of(["horizontal", "any"]))) == 2


def test_settings_of_the_command_reach_the_options_that_readings_choose(planner: Planner):
    composer = Composer(sweep=planner.composer.config(["tracking=none"]))
    config = OmegaConf.create({"study": {"blocks": BLOCKS, **of(["walls"])}})
    assert len(plan_study("mine", config, ("tracking=none",), Planner(composer))) == 4


def test_constraints_drop_changed_points_as_well(planned):
    constraint = {"drop": 'world == "walled" and representation == "direction"', "why": "not of interest"}
    plan = planned(BLOCKS, **of(["walls", "any"], order=2), constraints={"no_walls": constraint})
    assert len(plan) == 6
    assert [(each.constraint, each.count) for each in plan.dropped] == [("no_walls", 2)]


def test_points_of_included_studies_are_changed(planner: Planner):
    study = {"includes": ["table4"], **of(["horizontal", "any"], order=2, values={"task.periods": 9})}
    plan = plan_study("varied", OmegaConf.create({"study": study}), ("world.size=5", "task.goals=1"), planner)
    assert [p.studies for p in plan] == [("varied", "table4")] * 2 + [("varied",)] * 4
    assert [p.point.task.periods for p in plan] == [500] * 2 + [9] * 4
    assert (plan.combinations, sum(each.count for each in plan.dropped)) == (8, 2)


@pytest.mark.parametrize(
    ("variations", "message"),
    [
        (["any"], "variations: should be a mapping with readings"),
        ({"readings": {"a": {"lerner.alpha": 0.1}}}, "variations: reading a: lerner.alpha: no such key of points"),
        ({"readings": {"a": {"learner.alpah": 0.1}}}, "reading a: no point of this study has learner.alpah"),
        ({"readings": {"a": {"learner.alpha": "0.1,0.2"}}}, "learner.alpha=0.1,0.2: should be one value"),
        ({"readings": {"a": {"learner.alpha": 7}}}, "learner.alpha=7: "),
        ({"readings": READINGS, "order": 0}, "variations.order=0: "),
        ({"readings": READINGS, "around": [["all"]]}, "around: all: no such reading"),
        (
            {"readings": READINGS, "also": [["any", "any action"]]},
            "also: any action: no such reading",
        ),
        ({"readings": READINGS, "around": [["slow", "fast"]]}, "around: slow, fast: should be readings that change"),
        ({"readings": READINGS, "trebles": []}, "variations.trebles: "),
    ],
    ids=str,
)
def test_an_error_names_the_study_and_the_reading(planned, variations: object, message: str):
    with pytest.raises(ConfigError) as caught:
        planned(BLOCKS, variations=variations)
    assert message in str(caught.value)
    assert str(caught.value).startswith("study mine")


def test_very_many_combinations_are_counted_before_they_are_planned(planned):
    with pytest.raises(ConfigError, match="study mine: 140,000 combinations, more than max_points"):
        planned({"a": {"seed": "range(0,20000)"}}, **of(READINGS))


def test_many_points_are_planned_fast(planned):
    begun = time.process_time()
    plan = planned({"a": {"seed": "range(0,100)"}}, **of(["any", "first", "walls", "slow"], order=2))
    assert len(plan) == 100 * 11
    assert time.process_time() - begun < 3
