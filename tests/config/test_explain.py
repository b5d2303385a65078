"""Messages for invalid configurations name the key, the value and what would be right."""

from __future__ import annotations

import pytest

from rl_design_space.config.explain import unknown_option
from rl_design_space.errors import ConfigError
from rl_design_space.plan.planner import Planner, plan_point
from rl_design_space.run.settings import build_settings
from tests.command_runner import python

OPTION = "name exactly one option"
SIZE = "a size is a whole number of at least 2, or two of them, [dx, dy]"

#: Overrides, and what the message must contain.
POINTS = [
    # Unknown names.
    ("representation=ad_hic", ["representation=ad_hic: no such option", "did you mean representation=ad_hoc?"]),
    ("representation=direc", ["did you mean representation=direct?", "aggregated, direct, direction, distance"]),
    ("exploration=quadratic", ["exploration=quadratic: no such option", "exponential, linear, optimistic"]),
    ("learner=sarza", ["learner=sarza: no such option", "did you mean learner=sarsa?"]),
    ("study=tabel4", ["study=tabel4: no such option", "did you mean study=table4?"]),
    ("reprsentation=ad_hoc", ["reprsentation: no such", "did you mean representation?"]),
    ("tsak.goals=2", ["tsak", "no such", "did you mean task"]),
    ("task.gaols=2", ["task.gaols: no such key in Task", "did you mean task.goals?"]),
    ("exploration=linear exploration.kk=1", ["exploration.kk: no such key in Linear", "did you mean exploration.k?"]),
    ("exploration.k=0.1", ["exploration.k: no such key in Constant", "there is epsilon"]),
    ("exploration=exponential exploration.k=0.1", ["exploration.k: no such key in Exponential", "l, start"]),
    ("task.goals.x=3", ["task.goals.x: no such key"]),
    ("+colour=red", ["colour: no such key", "exploration", "world"]),
    ("++colour=red", ["colour: no such key"]),
    ("+world.depth=3", ["world.depth: no such key", "size"]),
    ("++task.goal=3", ["task.goal: no such key", "did you mean task.goals?"]),
    ("hydra.jobb=1", ["hydra.jobb: no such key", "did you mean hydra.job?"]),
    # Wrong types; nothing is converted silently.
    ("task.goals=many", ["task.goals=many", "a valid integer"]),
    ("task.goals='3'", ['task.goals="3"', "a valid integer, not text", "oc.decode"]),
    ("task.goals=${oc.env:NO_SUCH_VARIABLE,3}", ['task.goals="3"', "not text", "${oc.decode:${oc.env:NAME}}"]),
    ("world.size='10'", ['world.size="10"', "a whole number", "not text"]),
    ("world.size=010", ['world.size="010"', "not text; numbers are decimal, without leading zeros"]),
    ("task.goals=1:30", ['task.goals="1:30"', "without leading zeros, colons and letters"]),
    ("task.goals=3.0", ["task.goals=3.0", "a valid integer"]),
    ("task.goals=true", ["task.goals=true", "a valid integer"]),
    ("task.periods=null", ["task.periods=null", "a valid integer"]),
    ("seed=0.5", ["seed=0.5", "a valid integer"]),
    ("learner.alpha=small", ["learner.alpha=small", "a valid number"]),
    ("learner.ties=false", ["learner.ties=false", "'random' or 'first'"]),
    ("msa.lengths=3", ["msa.lengths=3: should be a list, such as [3]"]),
    ("msa.lengths=[2.5]", ["msa.lengths.0=2.5", "a valid integer"]),
    ("task=5", ["task=5", "Task"]),
    # Right types, values out of range.
    ("exploration=linear exploration.k=-0.01", ["exploration.k=-0.01", "greater than or equal to 0"]),
    ("exploration=linear exploration.start=1.5", ["exploration.start=1.5", "less than or equal to 1"]),
    ("exploration=linear exploration.k=inf", ["exploration.k=inf", "finite"]),
    ("exploration=exponential exploration.l=0", ["exploration.l=0", "greater than 0"]),
    ("exploration=exponential exploration.l=-2", ["exploration.l=-2", "greater than 0"]),
    ("exploration=exponential exploration.l=nan", ["exploration.l=nan", "finite"]),
    ("exploration=sigmoidal exploration.p=0", ["exploration.p=0", "greater than 0"]),
    ("exploration=sigmoidal exploration.first_trial=-1", ["exploration.first_trial=-1", "greater than or equal to 0"]),
    ("exploration.epsilon=1.01", ["exploration.epsilon=1.01", "less than or equal to 1"]),
    ("world.size=1", ["world.size=1", SIZE]),
    ("world.size=[5,1]", ["world.size=[5, 1]", SIZE]),
    ("world.size=[3,4,5]", ["world.size=[3, 4, 5]", SIZE]),
    ("world.size=2.5", ["world.size=2.5", SIZE]),
    ("task.goals=0", ["task.goals=0", "greater than or equal to 1"]),
    ("task.goals=100", ["task.goals=100", "at most 99 goals"]),
    ("task.goals=9 world.size=3", ["task.goals=9", "at most 8 goals"]),
    ("task.max_steps=0", ["task.max_steps=0", "greater than or equal to 1"]),
    ("msa=length_3 msa.lengths=[-3]", ["msa.lengths.0=-3", "greater than or equal to 2"]),
    ("msa.lengths=[2,1]", ["msa.lengths.1=1", "greater than or equal to 2"]),
    ("msa.lengths=[3,2,3]", ["msa.lengths=[3, 2, 3]", "once"]),
    ("msa.propagation=some", ["msa.propagation=some", "'primitives', 'all_shorter', 'consistent' or 'none'"]),
    ("learner.gamma=1.1", ["learner.gamma=1.1", "less than or equal to 1"]),
    ("learner.alpha=-0.1", ["learner.alpha=-0.1", "greater than or equal to 0"]),
    ("seed=-1", ["seed=-1", "greater than or equal to 0"]),
    ("seed=18446744073709551616", ["seed=18446744073709551616", "less than 18446744073709551616"]),
    # One of several types: no names of validators.
    ("curriculum=zero_shot curriculum.size=-3", [f"curriculum.size=-3: {SIZE}; or should be 'same'"]),
    ("representation=aggregated representation.block=0", ["representation.block=0: should be greater than or equal"]),
    ("representation=aggregated representation.block=[2,0]", ["representation.block.1=0: should be greater than or"]),
    ("representation=aggregated representation.block=[2,3,4]", ["block=[2, 3, 4]: should have at most 2 items, not 3"]),
    ("curriculum=coarse_to_fine curriculum.sizes=5", ["curriculum.sizes=5: should be a list, such as [5]"]),
    # Missing values.
    ("seed=???", ["seed=???", "needs a value"]),
    ("world.size=???", ["world.size=???", "needs a value"]),
    ("exploration=linear exploration.k=???", ["exploration.k=???", "needs a value"]),
    ("msa.lengths=[???]", ["msa.lengths", "???", "needs a value"]),
    ("~seed", ["seed: missing"]),
    ("~task", ["task: missing"]),
    ("~representation", ["representation", OPTION]),
    ("representation=null", ["representation", OPTION]),
    ("~world._target_", ["world._target_=???", "name the class"]),
    # Several values where one is expected.
    ("representation=[ad_hoc,direction]", ["representation", OPTION]),
    ("world.size=10,20", ["world.size=10,20", "several values make a sweep", "-m"]),
    ("representation=ad_hoc,direction", ["representation=ad_hoc,direction", "several values make a sweep", "-m"]),
    ("seed=range(0,3)", ["seed=range(0,3)", "-m"]),
    # Overrides that cannot be parsed, and interpolations that cannot be resolved.
    ("goals", ["goals: not an override", "key=value"]),
    ("world.size=[10", ['world.size=[10: character 12, "[", is not closed', """'world.size="[10"'"""]),
    ("task.goals=${", ['task.goals=${: character 13, "{", cannot be used here; quoted, it is text: ']),
    ("task.goals=${nowhere}", ["task.goals: ", "'nowhere' not found"]),
    ("task.goals=${task.gaols}", ["task.goals: ", "'task.gaols' not found"]),
    ("seed=${oc.env:NO_SUCH_VARIABLE}", ["NO_SUCH_VARIABLE", "seed"]),
    # Classes.
    ("world._target_=no.such.Thing", ["world._target_=no.such.Thing", "cannot be imported", "'no'"]),
    ("world._target_=rl_design_space.design.Tours", ["world._target_=", "cannot be imported", "'Tours'"]),
    ("world._target_=Torus", ["world._target_=Torus", "cannot be imported"]),
    ("world._target_=rl_design_space.design.cell_count", ["cell_count", "should name a class"]),
    ("world._target_=builtins.dict", ["world._target_=builtins.dict", "should be a frozen dataclass"]),
    ("world._target_=null", ["world._target_=null"]),
    ("world._target_=3", ["world._target_=3"]),
    ("representation._target_=rl_design_space.design.Torus", ["representation=Torus", "it has no observation()"]),
    ("~world.size world._target_=rl_design_space.design.AdHoc", ["world=AdHoc", "it has no next_cell(), offset()"]),
    ("world._target_=rl_design_space.design.GoalReward", ["world.size: no such key", "step"]),
    ("curriculum._target_=rl_design_space.design.CoarseToFine curriculum.sizes=[3]",
     ["curriculum.sizes: a field of CoarseToFine that the file", "+curriculum.sizes=VALUE sets it"]),
    ("world=10", ["world=10"]),
]  # fmt: skip

SETTINGS = [
    ("threads=0", ["threads=0", "greater than or equal to 1"]),
    ("threads=1.5", ["threads=1.5", "a valid integer"]),
    ("threads=all", ["threads=all", "a valid integer"]),
    ("outputs=''", ["outputs="]),
    ("outputs=null", ["outputs=null", "a valid string"]),
    ("~outputs", ["outputs: missing"]),
    ("~tracking", ["tracking: missing"]),
    ("tracking=null", ["tracking", OPTION]),
    ("tracking=sqlit", ["tracking=sqlit: no such option", "did you mean tracking=sqlite?"]),
    ("tracking.curves=[steps/q11]", ["tracking.curves.0=steps/q11", "steps/q10, steps/q90", "epsilon"]),
    ("tracking.curves=[epsilon,steps/mean]", ["tracking.curves.1=steps/mean", "recorded anyway"]),
    ("tracking.curves=epsilon", ["tracking.curves=epsilon"]),
    ("tracking.uri=mlflow.db", ["tracking.uri=mlflow.db", "sqlite:///"]),
    ("tracking.uri=/srv/mlflow", ["tracking.uri=/srv/mlflow", "sqlite:///"]),
    ("tracking.uri=sqlite:///", ["tracking.uri=sqlite:///: should be a tracking URI"]),
    ("tracking.uri=null", ["tracking.uri=null", "a valid string"]),
    ("tracking.uri=???", ["tracking.uri=???", "needs a value"]),
    ("tracking.experiment=''", ["tracking.experiment="]),
    ("tracking.experimnt=x", ["tracking.experimnt: no such key", "did you mean tracking.experiment?"]),
    ("tracking=none tracking.uri=x:", ["tracking.uri: no such key in NoTracking"]),
    ("tracking._target_=rl_design_space.design.AdHoc", ["tracking.uri: no such key"]),
]


def cases(table: list[tuple[str, list[str]]]) -> list:
    return [pytest.param(*case, id=case[0]) for case in table]


def assert_told(error: ConfigError, expected: list[str]) -> None:
    """Check that a message contains these words and no terms of the underlying libraries."""
    message = str(error)
    assert [words for words in expected if words not in message] == [], message
    terms = ("constrained-", "function-", "union[", "tuple", "pydantic", "omegaconf", "hydra.errors", "full_key")
    for foreign in (*terms, "object_type", "Traceback", "<class"):
        assert foreign not in message


@pytest.mark.parametrize(("typed", "expected"), cases(POINTS))
def test_an_invalid_point_names_the_key_the_value_and_the_fix(typed, expected: list[str], planner: Planner):
    with pytest.raises(ConfigError) as caught:
        planner(typed.split(" "))
    assert_told(caught.value, expected)


@pytest.mark.parametrize(("typed", "expected"), cases(SETTINGS))
def test_an_invalid_setting_names_the_key_the_value_and_the_fix(typed, expected: list[str], planner: Planner):
    with pytest.raises(ConfigError) as caught:
        build_settings(planner.composer.config(typed.split(" ")))
    assert_told(caught.value, expected)


@pytest.mark.parametrize(
    ("group", "option", "package"),
    [
        ("hydra/sweeper", "optuna", "rl-design-space[optuna]"),
        ("hydra/launcher", "joblib", "hydra-joblib-launcher"),
        ("hydra/launcher", "submitit_slurm", "hydra-submitit-launcher"),
    ],
)
def test_a_missing_package_is_named(group: str, option: str, package: str):
    message = str(unknown_option(group, option, ["basic", "design"]))
    assert message == f"{group}={option}: not installed; pip install '{package}' adds it"


def test_all_invalid_values_of_an_option_are_listed():
    with pytest.raises(ConfigError) as caught:
        plan_point(["learner.alpha=2", "learner.gamma=2", "learner.ties=none"])
    lines = str(caught.value).splitlines()
    assert [line.partition("=")[0] for line in lines] == ["learner.alpha", "learner.gamma", "learner.ties"]


def test_the_error_of_a_class_is_quoted(tmp_path, monkeypatch: pytest.MonkeyPatch):
    (tmp_path / "own_world.py").write_text(
        "from dataclasses import dataclass\n"
        "from rl_design_space.design import Torus\n"
        "@dataclass(frozen=True)\n"
        "class Ring(Torus):\n"
        "    def __post_init__(self):\n"
        "        raise ValueError('rings are out of stock')\n",
        encoding="utf-8",
    )
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(ConfigError, match=r"world: .*rings are out of stock"):
        plan_point(["world._target_=own_world.Ring"])


def test_the_error_of_a_broken_module_is_quoted(tmp_path, monkeypatch: pytest.MonkeyPatch):
    (tmp_path / "broken_world.py").write_text("import no_such_library\n", encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(ConfigError, match=r"world\._target_=broken_world\.Ring: .*no_such_library"):
        plan_point(["world._target_=broken_world.Ring"])


def test_config_errors_are_value_errors_and_need_nothing_heavy():
    assert issubclass(ConfigError, ValueError)
    program = "import sys; import rl_design_space.errors; print('hydra' in sys.modules, 'pydantic' in sys.modules)"
    assert python(program).split() == ["False", "False"]


@pytest.mark.parametrize(
    ("name", "hint"),
    [
        ("world", "; did you mean c.world?"),
        ("wor", "; did you mean c.world?"),
        ("wrold", "; did you mean c.world?"),
        ("zzzz", ""),
        ("", ""),
    ],
)
def test_the_most_similar_name_is_suggested(name: str, hint: str):
    found = str(ConfigError.unknown("key", name, ["world", "task"], prefix="c."))
    assert found == f"c.{name}: no such key{hint} (there is task, world)"


@pytest.mark.parametrize(
    ("value", "typed"),
    [
        *((None, "null"), (True, "true"), (0, "0"), (1, "1"), (0.5, "0.5"), ("a", "a")),
        ([1, None, (2, False)], "[1, null, [2, false]]"),
    ],
    ids=str,
)
def test_values_are_shown_as_typed(value: object, typed: str):
    assert str(ConfigError.at("key", value, "no")) == f"key={typed}: no"
