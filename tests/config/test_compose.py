"""Points from overrides: the composer gives the same results as Hydra, faster."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress

import hydra
import pytest
import yaml
from hydra.core.global_hydra import GlobalHydra
from hydra.errors import HydraException
from hypothesis import given, settings
from hypothesis import strategies as st
from omegaconf import DictConfig, OmegaConf
from omegaconf.errors import OmegaConfBaseException

from rl_design_space import DesignPoint
from rl_design_space._paths import CONF
from rl_design_space.config.compose import CONFIG_NAME, OPTION_GROUPS, Composer, shipped_config
from rl_design_space.design import (
    AdHoc,
    Direction,
    Exponential,
    GoalReward,
    Linear,
    MultiStepActions,
    Task,
    Torus,
    Walled,
)
from rl_design_space.errors import ConfigError
from rl_design_space.plan.planner import plan_point

VALUES = (
    *("0", "1", "7", "-3", "0.25", "1e-3", "-0.0", "null", "true", "???", "[]", "[2,3]", "[4, [5, 6]]", "word"),
    *("'a, b'", '"x = y"', "a\\,b", "{a: 1}", "[${task.goals}]", "${task.goals}", "${seed}", "x${outputs}y"),
    *("${exploration}", "${nowhere}"),
)
PLAIN_KEYS = ("seed", "threads", "outputs", "task.goals", "task.trials", "task.periods", "task.max_steps")
FILES = {group: sorted((CONF / group).glob("*.yaml")) for group in (*OPTION_GROUPS, "tracking")}
Overrides = list[str]


@st.composite
def override_lists(draw: st.DrawFn) -> Overrides:
    """Draw options and values in any order; values of any type, for existing keys, possibly repeated."""
    options, keys = [], [*PLAIN_KEYS, "tracking.experiment"]
    for group, files in FILES.items():
        if file := draw(st.sampled_from([None, *files])):
            options.append(f"{group}={file.stem}")
            fields = set(yaml.safe_load(file.read_text(encoding="utf-8")))
            keys += [f"{group}.{field}" for field in sorted(fields - {"_target_"})]
    if "tracking=none" in options:
        keys.remove("tracking.experiment")
    value = st.builds("{}={}".format, st.sampled_from(keys), st.sampled_from(VALUES))
    return draw(st.permutations(options + draw(st.lists(value, max_size=6))))


def by_composer(overrides: Overrides) -> DictConfig:
    # Compose twice: the compared config comes from the cache, which earlier points must not change.
    composer = Composer()
    with suppress(ConfigError):
        composer.config([*overrides, "seed=12345", "task.goals=54321"])
    return composer.config(overrides)


def by_hydra(overrides: Overrides) -> DictConfig:
    return hydra.compose(CONFIG_NAME, overrides, return_hydra_config=True)


def outcome(how: Callable[[Overrides], DictConfig], overrides: Overrides) -> object:
    """Return the config without Hydra's record of the call, and the chosen options; or that composing fails."""
    try:
        config = how(overrides)
    except (ConfigError, HydraException, OmegaConfBaseException):
        return "refused"
    choices = dict(config.hydra.runtime.choices)
    return {key: value for key, value in OmegaConf.to_container(config).items() if key != "hydra"}, choices


@settings(deadline=None, max_examples=15)
@given(overrides=override_lists())
def test_the_composer_agrees_with_hydra(overrides: Overrides):
    with shipped_config():
        assert outcome(by_composer, overrides) == outcome(by_hydra, overrides)


@pytest.mark.parametrize(
    "overrides",
    [
        ["world=walled", "world.size=5", "world=torus"],
        ["world.size=5", "world=walled"],
        ["world=[torus]"],
        ["seed=1", "seed=2"],
        ["task={goals: 4}", "task.goals=5"],
        ["task.goals=5", "task={goals: 4}"],
        ["++world.size=7", "world.size=8"],
        ["world.size=8", "++world.size=7"],
        ["+note=a", "note=b"],
        ["world.size=5", "~world.size"],
        ["~world.size", "+world.size=5"],
        ["study=table4", "study.report.title=mine"],
        ["tracking=none", "outputs=elsewhere"],
        ["hydra.run.dir=elsewhere"],
        ["seed=[]", "seed={a: 1}"],
    ],
    ids=" ".join,
)
def test_the_order_of_overrides_counts_as_in_hydra(overrides: Overrides):
    with shipped_config():
        assert outcome(by_composer, overrides) == outcome(by_hydra, overrides)


@pytest.mark.parametrize(
    ("name", "composed"),
    [("table4", 1), ("readings_pairs", 2)],
    ids=["of a file alone", "with a defaults list"],
)
def test_the_config_of_a_study_is_that_of_hydra(name: str, composed: int, monkeypatch: pytest.MonkeyPatch):
    asked = []
    with shipped_config():
        expected = by_hydra([f"study={name}"])
        composer, compose = Composer(), hydra.compose
        monkeypatch.setattr(hydra, "compose", lambda *args, **others: asked.append(args) or compose(*args, **others))
        for title in ("mine", "yours"):
            assert composer.config([f"study={name}", f"study.report.title={title}"]).study.report.title == title
        assert OmegaConf.to_container(composer.config([f"study={name}"])) == OmegaConf.to_container(expected)
    # The config without a study is composed once; more is for Hydra to do only if the file is not all there is.
    assert len(asked) == composed


@pytest.mark.parametrize(
    ("overrides", "point"),
    [
        ([], DesignPoint()),
        (["seed=7", "task.goals=2"], DesignPoint(seed=7, task=Task(goals=2))),
        (["world=walled", "world.size=[4,3]"], DesignPoint(world=Walled(size=(4, 3)))),
        (["representation=direction", "representation.goals=all"],
         DesignPoint(representation=Direction(goals="all"))),
        (["exploration=linear", "exploration.k=0"], DesignPoint(exploration=Linear(k=0.0))),
        (["exploration=exponential", "exploration.l=1.05"], DesignPoint(exploration=Exponential(l=1.05))),
        (["msa=lengths_3_5", "msa.propagation=none"],
         DesignPoint(msa=MultiStepActions(lengths=(3, 5), propagation="none"))),
        (["msa.lengths=[7,2]"], DesignPoint(msa=MultiStepActions(lengths=(7, 2)))),
        (["reward=end_reward"], DesignPoint(reward=GoalReward(step=0.0, sub_goal=0.0))),
        (["task.trials=${task.goals}", "task.goals=4"], DesignPoint(task=Task(goals=4, trials=4))),
        (["world.size=${seed}", "seed=6"], DesignPoint(seed=6, world=Torus(size=6))),
        (["world=walled", "world._target_=rl_design_space.design.Torus"], DesignPoint()),
    ],
    ids=str,
)  # fmt: skip
def test_overrides_describe_a_point(overrides: Overrides, point: DesignPoint):
    assert DesignPoint.from_overrides(overrides) == point


def test_a_planned_point_keeps_its_options_and_overrides():
    planned = plan_point(["world.size=5", "exploration=linear", "outputs=here"])
    assert planned.options == {
        "world": "torus",
        "representation": "ad_hoc",
        "exploration": "linear",
        "msa": "none",
        "reward": "many_rewards",
        "learner": "q_learning",
        "curriculum": "none",
    }
    assert planned.overrides == ("world.size=5", "exploration=linear", "outputs=here")
    assert planned.studies == ()


def test_parameters_are_named_as_on_the_command_line():
    parameters = plan_point(["exploration=linear", "world.size=[4,5]", "msa=lengths_2_3"]).parameters
    assert parameters["exploration"] == "linear"
    assert parameters["exploration.k"] == 0.03
    assert parameters["world.size"] == [4, 5]
    assert parameters["msa.lengths"] == [2, 3]
    assert parameters["task.goals"] == 3
    assert parameters["seed"] == 0
    assert "threads" not in parameters


def test_the_parameters_of_a_point_are_overrides_that_describe_it():
    planned = plan_point(["world=walled", "world.size=[4,5]", "exploration=sigmoidal", "msa=lengths_2_3", "seed=3"])
    again = plan_point([f"{name}={value}" for name, value in planned.parameters.items()])
    assert again.point == planned.point
    assert again.options == planned.options


@pytest.mark.parametrize(
    ("overrides", "name"),
    [
        ([], "defaults"),
        (["world.size=5", "representation=direction"], "world.size=5 representation=direction"),
        (["outputs=x", "threads=1", "tracking=none", "hydra.verbose=true"], "defaults"),
        (["tracking.curves=[epsilon]", "seed=3", "threads=1"], "seed=3"),
    ],
    ids=str,
)
def test_the_name_lists_the_differences_from_the_default_point(overrides: Overrides, name: str):
    assert plan_point(overrides).name == name


def test_the_command_can_be_pasted_into_a_shell():
    planned = plan_point(["msa.lengths=[2, 3]", "task.trials=${task.goals}", "outputs=a b"])
    assert planned.command == (
        "rl-design-space 'msa.lengths=[2, 3]' 'task.trials=${task.goals}' 'outputs=a b'"
    )  # fmt: skip


# Hydra has one global state, which an application that uses this package as a library may have initialized.


@pytest.fixture
def outer(tmp_path_factory: pytest.TempPathFactory) -> Iterator[DictConfig]:
    """Initialize Hydra with the configuration of another application."""
    folder = tmp_path_factory.mktemp("outer")
    (folder / "app.yaml").write_text("colour: red\n", encoding="utf-8")
    with hydra.initialize_config_dir(str(folder), version_base="1.3"):
        yield hydra.compose("app")


@pytest.mark.parametrize("overrides", [[], ["world.size=1"], ["no such thing"]], ids=["right", "refused", "unparsable"])
def test_the_hydra_state_of_a_surrounding_application_is_restored(overrides: Sequence[str], outer: DictConfig):
    before = GlobalHydra.instance().hydra
    try:
        assert DesignPoint.from_overrides(overrides).representation == AdHoc()
    except ConfigError:
        assert overrides
    assert GlobalHydra.instance().hydra is before
    assert hydra.compose("app") == outer


def test_no_hydra_state_remains():
    assert not GlobalHydra.instance().is_initialized()
    DesignPoint.from_overrides(["world.size=5"])
    assert not GlobalHydra.instance().is_initialized()
