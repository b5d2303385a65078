"""Studies: unions of grids, and overrides of the command line."""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any

import pytest
from omegaconf import OmegaConf

from rl_design_space.config import user_config
from rl_design_space.config.compose import shipped_config
from rl_design_space.config.user_config import used
from rl_design_space.design import AdHoc, DesignPoint, Direction, Linear, Task, Torus
from rl_design_space.errors import ConfigError
from rl_design_space.plan import study as study_module
from rl_design_space.plan.grid import Grid
from rl_design_space.plan.planner import Planner
from rl_design_space.plan.study import Study, load_study, plan_overrides, plan_study, union


@pytest.fixture
def table4(planner: Planner):
    """Load Table 4 with overrides; all tests share one composer."""
    return lambda *overrides: load_study("table4", overrides, planner)


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


def test_an_override_of_another_key_applies_to_every_point(table4):
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


def test_an_override_may_sweep_a_key_that_the_study_does_not_set(table4):
    study = table4("world.size=10", "task.goals=1", "reward=many_rewards,end_reward", "seed=range(0,3)")
    assert len(study.plan) == 2 * 2 * 3


def test_the_last_of_two_overrides_wins(table4):
    assert {planned.point.world for planned in table4("world.size=10", "world.size=5").plan} == {Torus(size=5)}


def test_a_forced_override_replaces_a_sweep(table4):
    # It follows the overrides of the block, also in the command that is recorded with the point.
    study = table4("++world.size=5", "task.goals=1")
    assert {planned.point.world for planned in study.plan} == {Torus(size=5)}


@pytest.mark.parametrize("overrides", [(), ("world.size=5", "outputs=elsewhere"), ("task.trials=${task.goals}",)])
def test_the_command_of_a_planned_point_describes_the_same_point(table4, overrides: tuple[str, ...], planner: Planner):
    plan = table4("task.goals=2", *overrides).plan
    assert plan
    for planned in plan:
        assert planner(planned.overrides).fingerprint == planned.fingerprint


def test_settings_reach_the_study_and_the_command_of_every_point(table4):
    study = table4("outputs=elsewhere", "threads=1", "world.size=5")
    assert (study.config.outputs, study.config.threads) == ("elsewhere", 1)
    assert study.plan
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
        ({"representation": "glob(*, exclude=[d*,w*])"}, ["ad_hoc", "aggregated"]),
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
        ({"world.size": "[10"}, (), 'world.size=[10: character 12, "[", is not closed'),
        ({"seed": True}, (), "seed=true: should be a valid integer"),
        ({"seed": None}, (), "seed=null: should be a valid integer"),
        ({"seed": 1}, ("task.gaols=1",), "task.gaols: no such key in Task; did you mean task.goals?"),
    ],
    ids=str,
)
def test_an_error_in_a_block_names_the_study_and_the_block(planned, sweeps, overrides, message: str):
    with pytest.raises(ConfigError) as caught:
        planned({"fine": {"seed": 0}, "broken": sweeps}, *overrides)
    assert message in str(caught.value)
    assert str(caught.value).startswith("study mine, block ")
    assert "broken" in str(caught.value) or overrides


@pytest.mark.parametrize("blocks", [None, "a", ["seed=1"], {"a": None}, {"a": "seed=1"}, {"a": ["seed=1"]}], ids=str)
def test_invalid_blocks_are_refused(planned, blocks: object):
    with pytest.raises(ConfigError, match="study mine: needs blocks, each a mapping of keys to sweeps"):
        planned(blocks)


def test_a_study_without_any_block_is_refused(planned):
    with pytest.raises(ConfigError, match="study mine: no design points"):
        planned({})


def test_an_unknown_study_is_refused_with_a_suggestion():
    with pytest.raises(ConfigError, match=r"study=\.\./config: should be the name of a study"):
        load_study("../config", ())
    with shipped_config(), pytest.raises(ConfigError, match=r"study=table: .*did you mean study=table\d\?"):
        load_study("table", ())


def test_a_study_without_a_report_is_explained(table4):
    study = replace(table4("world.size=5"), config=OmegaConf.create({"study": {"blocks": {}}}))
    with pytest.raises(ConfigError, match="study table4: its file describes no report"):
        study.report()


def test_expanding_keeps_overrides_without_a_sweep(planner: Planner):
    assert list(Grid(["world.size=[3,4]", "seed=1,2", "task.goals=1"], planner.composer.parser)) == [
        ("world.size=[3,4]", "seed=1", "task.goals=1"),
        ("world.size=[3,4]", "seed=2", "task.goals=1"),
    ]


def test_studies_share_their_common_points(planned):
    mine = planned({"a": {"world.size": "4,5"}})
    yours = planned({"a": {"world.size": "5,6"}}, name="yours")
    both = union([mine, yours])
    assert [(p.name, p.studies) for p in both] == [
        ("world.size=4", ("mine",)),
        ("world.size=5", ("mine", "yours")),
        ("world.size=6", ("yours",)),
    ]
    assert (both.name, both.studies, both.combinations, both.duplicates) == ("mine,yours", ("mine", "yours"), 4, 1)


# Very many points.


def test_a_sweep_of_very_many_points_asks_for_their_number(planner: Planner, planned):
    with pytest.raises(ConfigError, match=r"^1,000,000 combinations, more than max_points=100000; .*=1000000$"):
        plan_overrides(["reward.step=range(0,1000)", "seed=range(0,1000)"], planner)
    with pytest.raises(ConfigError, match="study mine: 100,005 combinations, more than max_points=100000"):
        planned({"a": {"seed": "range(0,100000)"}, "b": {"seed": "range(0,5)"}})
    with pytest.raises(ConfigError, match="study table4: 18 combinations, more than max_points=17"):
        load_study("table4", ["max_points=17"], planner)
    assert len(plan_overrides(["seed=range(0,3)"], planner, max_points=3)) == 3


def test_planning_tells_how_far_it_is_and_can_be_interrupted(planner: Planner):
    told = []

    def progress(number: int, total: int) -> None:
        told.append((number, total))
        if number == 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        plan_overrides(["seed=range(0,4)", "world.size=4,5"], Planner(planner.composer, progress))
    assert told == [(1, 8), (2, 8), (3, 8)]


# Plans.


def test_the_axes_of_a_plan_are_the_parameters_that_differ(planner: Planner):
    found = plan_overrides(["representation=ad_hoc,direction", "world.size=4,5,6", "seed=7"], planner)
    assert found.axes == {
        "representation": {"ad_hoc": 3, "direction": 3},
        "world.size": {"4": 2, "5": 2, "6": 2},
    }
    assert (len(found), found.studies, found.name) == (6, (), "sweep")


@pytest.mark.parametrize("of", [1, 2, 3, 7, 20])
def test_shards_partition_the_plan(planner: Planner, of: int):
    sweeps = ["world.size=range(4,14)", "seed=0,1"]
    found = plan_overrides(sweeps, planner)
    shards = [found.shard(number, of) for number in range(1, of + 1)]
    assert sorted(p.name for shard in shards for p in shard) == sorted(p.name for p in found)
    assert max(map(len, shards)) - min(map(len, shards)) <= 1
    assert {shard.whole for shard in shards} == {20}
    # The shards do not depend on the order of the points.
    other = plan_overrides(sweeps[::-1], planner)
    assert {p.fingerprint for p in other.shard(1, of)} == {p.fingerprint for p in shards[0]}


# Studies of studies.


def test_a_study_that_several_include_is_planned_once(planner: Planner, monkeypatch: pytest.MonkeyPatch):
    planned: list[str] = []

    def counted(name: str, *others: Any) -> Any:
        planned.append(name)
        return plan_study(name, *others)

    monkeypatch.setattr(study_module, "plan_study", counted)
    paper = load_study("paper", ("task.periods=5",), planner)
    assert len(planned) == len(set(planned)) > 5
    assert {each.name for each in paper.included} >= {"table4", "claims", "readings"}


def test_a_study_plans_another_with_its_overrides(planner: Planner, monkeypatch: pytest.MonkeyPatch):
    claims = load_study("claims", ("task.periods=5",), planner)
    assert claims.another("table4") is claims.included[1]
    monkeypatch.setattr(study_module, "Planner", None)  # no other planner is made
    other = claims.another("table1")
    assert (other.name, other.overrides) == ("table1", ("task.periods=5",))


def test_a_study_may_include_others(planner: Planner):
    config = OmegaConf.create({"study": {"includes": ["table4", "table2"]}})
    found = plan_study("both", config, ("task.periods=5",), planner)
    parts = [load_study(name, ("task.periods=5",), planner).plan for name in ("table4", "table2")]
    assert {p.fingerprint for p in found} == {p.fingerprint for part in parts for p in part}
    assert found.studies == ("both", "table4", "table2")
    assert {p.studies[0] for p in found} == {"both"}
    assert {p.point.task.periods for p in found} == {5}


@pytest.mark.parametrize("included", ["table4", [1], ["both"], [["table4"]]], ids=str)
def test_includes_is_a_list_of_other_studies(planner: Planner, included: object):
    config = OmegaConf.create({"study": {"includes": included}})
    with pytest.raises(ConfigError, match="study both: includes should be a list of the names of other studies"):
        plan_study("both", config, (), planner)


def test_includes_do_not_lead_in_a_circle(tmp_path: Path):
    (tmp_path / "study").mkdir()
    for name, other in (("one", "two"), ("two", "three"), ("three", "two")):
        (tmp_path / "study" / f"{name}.yaml").write_text(f"includes: [table4, {other}]\n", encoding="utf-8")
    with user_config.used(tmp_path), shipped_config(), pytest.raises(ConfigError) as caught:
        load_study("one", ())
    assert str(caught.value).endswith("includes should not lead back to itself: two includes three includes two")


def test_a_report_may_need_no_points(planner: Planner):
    config = OmegaConf.create({"study": {"report": {"_target_": "somewhere.Report"}}})
    assert len(plan_study("picture", config, (), planner)) == 0


@pytest.mark.parametrize(("periods", "mark"), [(500, ""), (50, "quick look: 50 periods instead of 500"), (900, "")])
def test_a_study_of_fewer_periods_is_marked(table4, periods: int, mark: str):
    assert table4(f"task.periods={periods}").mark == mark


def test_periods_that_a_file_asks_for_are_no_quick_look(tmp_path: Path):
    folder = tmp_path / "study"
    folder.mkdir()
    (folder / "mine.yaml").write_text('blocks: {a: {task.periods: "30,60", seed: "0,1"}, b: {task.periods: 40}}')
    (folder / "both.yaml").write_text("includes: [mine]")
    with used(tmp_path), shipped_config():
        planner = Planner()
        for name in ("mine", "both"):
            for same in ((), ("world.size=4",), ("world.size=4", "task.periods=60")):
                assert load_study(name, same, planner).mark == ""
            assert load_study(name, ("task.periods=10",), planner).mark == "quick look: 10 periods instead of 60"
