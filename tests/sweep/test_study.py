"""Studies: unions of grids, and what the command line makes of them."""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from typing import Any

import pytest
from omegaconf import OmegaConf

from rl_design_space.design import AdHoc, DesignPoint, Direction, Linear, Task, Torus
from rl_design_space.errors import ConfigError
from rl_design_space.sweep.arguments import split_arguments
from rl_design_space.sweep.compose import Composer, shipped_config
from rl_design_space.sweep.grid import expand
from rl_design_space.sweep.plan import PlannedPoint
from rl_design_space.sweep.study import Study, load_study, plan_study


@pytest.fixture
def planned(composer: Composer):
    """Plan a study of these blocks, as if it were a file of conf/study called `mine`."""

    def plan(blocks: Any, *overrides: str) -> list[PlannedPoint]:
        return plan_study("mine", OmegaConf.create({"study": {"blocks": blocks}}), overrides, composer)

    return plan


@pytest.fixture
def table4(composer: Composer, monkeypatch: pytest.MonkeyPatch):
    """Load Table 4 with these overrides; all tests share what was composed."""
    monkeypatch.setattr("rl_design_space.sweep.study.Composer", lambda: composer)
    return lambda *overrides: load_study("table4", overrides)


def cells(study: Study) -> set[tuple[str, float, object, int]]:
    names = ("representation", "exploration.k", "world.size", "task.goals")
    found = [tuple(planned.parameters[name] for name in names) for planned in study.plan]
    assert len(set(found)) == len(found)
    return set(found)


def test_table_4_is_eighteen_points(table4):
    study = table4()
    ways = ((AdHoc(), Linear(k=0.03)), (Direction(), Linear(k=0.02)))
    assert [planned.point for planned in study.plan] == [
        DesignPoint(representation=representation, exploration=exploration, world=Torus(size=d), task=Task(goals=n))
        for (representation, exploration), d, n in product(ways, (10, 20, 30), (1, 2, 3))
    ]


def test_an_override_of_something_else_holds_for_every_point(table4):
    study = table4("task.periods=50", "learner.explore=all")
    assert len(study.plan) == 18
    assert {planned.point.task.periods for planned in study.plan} == {50}
    assert {planned.point.learner.explore for planned in study.plan} == {"all"}


def test_an_override_replaces_what_the_blocks_choose(table4):
    study = table4("exploration.k=0.05")
    assert {planned.point.exploration for planned in study.plan} == {Linear(k=0.05)}
    assert len(study.plan) == 18


def test_an_override_narrows_a_sweep(table4):
    assert cells(table4("world.size=10")) == {
        (*way, 10, n) for way, n in product((("ad_hoc", 0.03), ("direction", 0.02)), (1, 2, 3))
    }


def test_an_override_extends_a_sweep(table4):
    assert cells(table4("world.size=10,40", "task.goals=1")) == {
        (*way, d, 1) for way, d in product((("ad_hoc", 0.03), ("direction", 0.02)), (10, 40))
    }


def test_an_override_sweeps_what_the_study_leaves_alone(table4):
    study = table4("world.size=10", "task.goals=1", "reward=many_rewards,end_reward", "seed=range(0,3)")
    assert len(study.plan) == 2 * 2 * 3


def test_the_last_of_two_overrides_counts(table4):
    assert {planned.point.world for planned in table4("world.size=10", "world.size=5").plan} == {Torus(size=5)}


def test_a_forced_override_is_not_lost(table4):
    # It stands after what the block says, and the command recorded for the point gives it the same meaning.
    study = table4("++world.size=5", "task.goals=1")
    assert {planned.point.world for planned in study.plan} == {Torus(size=5)}


@pytest.mark.parametrize("overrides", [(), ("world.size=5", "outputs=elsewhere"), ("task.trials=${task.goals}",)])
def test_the_command_of_a_planned_point_makes_the_same_point(table4, overrides: tuple[str, ...], composer: Composer):
    for planned in table4("task.goals=2", *overrides).plan:
        assert composer(planned.overrides).fingerprint == planned.fingerprint


def test_settings_reach_the_study_and_the_command_of_every_point(table4):
    study = table4("outputs=elsewhere", "threads=1", "world.size=5")
    assert (study.config.outputs, study.config.threads) == ("elsewhere", 1)
    assert all("outputs=elsewhere threads=1" in planned.command for planned in study.plan)
    assert all("outputs" not in planned.name for planned in study.plan)


def test_commands_of_a_study(table4):
    study = table4("world.size=[4, 5]", "study=table4")
    assert study.command == "rl-design-space study=table4 'world.size=[4, 5]'"
    assert study.report_command == "rl-design-report table4 'world.size=[4, 5]'"


# Blocks.


def test_all_combinations_of_a_block_are_points(planned):
    found = planned({"a": {"world.size": "4,5", "seed": "range(0,3)", "task.goals": 2}})
    assert [p.name for p in found] == [
        f"world.size={d} seed={seed} task.goals=2" for d, seed in product((4, 5), (0, 1, 2))
    ]


def test_equal_points_of_two_blocks_run_once(planned):
    found = planned(
        {
            "a": {"world.size": "4,10"},
            "b": {"reward": "many_rewards,each_success"},
            "c": {"world.size": "[4,4]", "reward.step": -0.1},
        }
    )
    assert [p.name for p in found] == ["world.size=4", "world.size=10", "reward=each_success"]


def test_a_block_without_sweeps_is_the_default_point(planned):
    assert [p.point for p in planned({"default": {}})] == [DesignPoint()]


@pytest.mark.parametrize(
    ("sweeps", "names"),
    [
        ({"representation": "glob(d*)"}, ["direct", "direction", "distance"]),
        ({"representation": "glob(*, exclude=d*)"}, ["ad_hoc"]),
        ({"seed": "choice(3,1)"}, ["3", "1"]),
        ({"seed": "sort(3,1)"}, ["1", "3"]),
        ({"msa.lengths": [2, 3]}, ["[2,3]"]),
        ({"msa.lengths": "[2],[2,3]"}, ["[2]", "[2,3]"]),
        ({"exploration.epsilon": 1e-5}, ["1e-05"]),
        ({"task": {"goals": 2}}, ["{goals:2}"]),
    ],
    ids=str,
)
def test_the_ways_to_write_values(planned, sweeps: dict[str, object], names: list[str]):
    assert [p.name for p in planned({"a": sweeps})] == [f"{next(iter(sweeps))}={name}" for name in names]


def test_a_value_may_refer_to_another_of_its_point(planned):
    found = planned({"a": {"task.goals": "2,4", "task.trials": r"\${task.goals}"}})
    assert [p.point.task for p in found] == [Task(goals=2, trials=2), Task(goals=4, trials=4)]


@pytest.mark.parametrize(
    ("sweeps", "overrides", "message"),
    [
        ({"representation": "glob(x*)"}, (), "representation=glob(x*): matches nothing"),
        ({"seed": "range(3,0)"}, (), "seed=range(3,0): matches nothing"),
        ({"seed": 1}, ("representation=glob(x*)",), "representation=glob(x*): matches nothing"),
        ({"exploration": "linear", "exploration.k": "interval(0,1)"}, (), "exploration.k=interval(0,1): an interval"),
        ({"representation": "ad_hoc,ad_hic"}, (), "did you mean representation=ad_hoc?"),
        ({"exploration": "linear,exponential", "exploration.k": 0.1}, (), "exploration.k: no such key in Exponential"),
        ({"world.size": "10,1"}, (), "world.size=1: a size is a whole number of at least 2"),
        ({"world.size": "[10"}, (), "world.size=[10: not an override"),
        ({"seed": True}, (), "seed=true: should be a valid integer"),
        ({"seed": None}, (), "seed=null: should be a valid integer"),
        ({"seed": 1}, ("task.gaols=1",), "task.gaols: no such key in Task; did you mean task.goals?"),
    ],
    ids=str,
)
def test_what_is_wrong_in_a_block_is_told_with_study_and_block(planned, sweeps, overrides, message: str):
    with pytest.raises(ConfigError) as caught:
        planned({"fine": {"seed": 0}, "broken": sweeps}, *overrides)
    assert message in str(caught.value)
    assert str(caught.value).startswith("study mine, block ")
    assert "broken" in str(caught.value) or overrides


@pytest.mark.parametrize("blocks", [None, "a", ["seed=1"], {"a": None}, {"a": "seed=1"}, {"a": ["seed=1"]}], ids=str)
def test_blocks_that_are_none_are_refused(planned, blocks: object):
    with pytest.raises(ConfigError, match="study mine: needs blocks, each a mapping of keys to sweeps"):
        planned(blocks)


def test_a_study_without_any_block_is_refused(planned):
    with pytest.raises(ConfigError, match="study mine: no design point in it"):
        planned({})


def test_a_study_that_does_not_exist_is_refused_with_those_that_do():
    with shipped_config(), pytest.raises(ConfigError, match=r"study=table: .*did you mean study=table4\?"):
        load_study("table", ())


def test_a_study_without_a_report_says_so(table4):
    study = replace(table4("world.size=5"), config=OmegaConf.create({"study": {"blocks": {}}}))
    with pytest.raises(ConfigError, match="study table4: its file describes no report"):
        study.report()


def test_expanding_keeps_what_is_no_sweep(composer: Composer):
    assert expand(["world.size=[3,4]", "seed=1,2", "task.goals=1"], composer.parser) == [
        ("world.size=[3,4]", "seed=1", "task.goals=1"),
        ("world.size=[3,4]", "seed=2", "task.goals=1"),
    ]


@pytest.mark.parametrize(
    ("argument", "is_for_points"),
    [
        ("task.periods=5", True),
        ("world.size=4,5", True),
        ("+learner.extra=1", True),
        ("++seed=1", True),
        ("representation=direction", True),
        ("threadsafe.x=1", True),
        ("outputs=x", False),
        ("threads=1", False),
        ("tracking=none", False),
        ("tracking.uri=sqlite:///x.db", False),
        ("~tracking", False),
        ("hydra.verbose=true", False),
        ("hydra/launcher=basic", False),
        ("study.report.title=x", False),
        ("--config-dir=mine", False),
        ("-m", False),
        ("--help", False),
    ],
)
def test_arguments_are_split_into_those_of_hydra_and_those_of_points(argument: str, is_for_points: bool):
    expected = (["study=table4"], [argument]) if is_for_points else (["study=table4", argument], [])
    assert split_arguments(["study=table4", argument]) == expected


def test_without_a_study_all_arguments_are_hydras():
    arguments = ["task.periods=5", "-m", "world.size=4,5"]
    assert split_arguments(arguments) == (arguments, [])
