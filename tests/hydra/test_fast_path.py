"""Points are assembled without Hydra only where the result equals what Hydra composes."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import hydra
import pytest
import yaml
from hydra.errors import HydraException
from hypothesis import given, settings
from hypothesis import strategies as st
from omegaconf.errors import OmegaConfBaseException

from rl_design_space.config.assemble import Assembler
from rl_design_space.config.compose import CONFIG_NAME, Composer, shipped_config
from rl_design_space.errors import ConfigError
from rl_design_space.plan.plan import PlannedPoint
from rl_design_space.plan.planner import Planner, plan_composed
from tests.config.test_compose import FILES, override_lists

Overrides = Sequence[str]

#: Overrides in other forms than `group=option` or `key=value`, and overrides that Hydra refuses.
UNUSUAL = (
    *("world='walled'", 'world="walled"', "world=[walled]", "world=null", "world=walled.yaml", "world=/walled"),
    *("/world=walled", "world=../msa/none", "world@reward=torus", "world@world=walled", "+world=walled"),
    *("++world=walled", "~world", "++world.size=7", "+world.depth=3", "~world.size", "world.size=range(4,6)"),
    *("world.size=", "world.size=int(5)", "world.size='5'", "world.size=5.0", "world.size=[4,'5']", "world.size.x=5"),
    *("world={size:5}", "task={goals:2}", "task=null", "msa.lengths.0=3", "msa.lengths=2", "seed=0x10", "seed=+1"),
    *("seed=1e3", "seed=true", "seed=null", "seed=", "seed.x=1", "exploration.epsilon=nan"),
    *("exploration.epsilon=inf", "exploration.epsilon=.5", "seed=\\${x}", "seed='${task.goals}'"),
    *("reward.step=\\'1\\'", "reward.step=' 1 '", "world._target_=rl_design_space.design.Walled"),
    *("world._target_=torus", "world._target_=null", "outputs='a b'", "threads=0", "shard=9/2", "objective=word"),
    *("tracking=null", "~tracking", "tracking=none", "study=table4", "study=none_such", "hydra.verbose=true"),
    *("+hydra.x=1", "seed", "world.size=[", "task.goals=1 2", "über=1", "study.x=1"),
)


def outcome(how: Callable[[Overrides], PlannedPoint], overrides: Overrides) -> object:
    """Return all values of a planned point with their types; or that planning fails."""
    try:
        planned = how(overrides)
    except ConfigError:
        return "refused"
    assert planned.overrides == tuple(overrides)
    return repr(planned.point), dict(planned.options), planned.fingerprint


def by_hydra(overrides: Overrides, searchpath: Overrides = ()) -> PlannedPoint:
    try:
        config = hydra.compose(CONFIG_NAME, [*searchpath, *overrides], return_hydra_config=True)
    except (ValueError, HydraException, OmegaConfBaseException) as error:  # Hydra has no error of its own for some
        raise ConfigError(str(error)) from error
    return plan_composed(config, config.hydra.runtime.choices, overrides)


@pytest.fixture(scope="module")
def planner() -> Iterator[Planner]:
    """One planner for all tests: a point must not change later ones."""
    with shipped_config():
        yield Planner()


def _values() -> dict[str, list[str]]:
    """Return the values of each key in the files under conf/, and a few numbers."""
    found: dict[str, set[str]] = {}
    for group, files in FILES.items():
        for file in files:
            for field, value in yaml.safe_load(file.read_text(encoding="utf-8")).items():
                if field != "_target_":
                    found.setdefault(f"{group}.{field}", {"2"}).add(str(value))
    found.pop("tracking.uri")  # interpolates
    found |= {key: {"1", "2", "7"} for key in ("seed", "task.goals", "task.trials", "task.periods", "task.max_steps")}
    return {key: sorted(values) for key, values in found.items()}


#: Allowed values by key.
VALUES = _values()
#: The default options.
DEFAULTS = {"torus", "ad_hoc", "constant", "none", "many_rewards", "q_learning", "sqlite"}


@st.composite
def plain_override_lists(draw: st.DrawFn) -> list[str]:
    """Draw options and allowed values in any order: most of them describe a point."""
    options, keys = [], [key for key in VALUES if key.partition(".")[0] not in FILES]
    for group, files in FILES.items():
        if file := draw(st.sampled_from([None, *files])):
            options.append(f"{group}={file.stem}")
        else:
            file = next(file for file in files if file.stem in DEFAULTS)
        fields = yaml.safe_load(file.read_text(encoding="utf-8"))
        keys += [f"{group}.{field}" for field in fields if f"{group}.{field}" in VALUES]
    chosen = draw(st.lists(st.sampled_from(keys), max_size=6))
    return draw(st.permutations(options + [f"{key}={draw(st.sampled_from(VALUES[key]))}" for key in chosen]))


@settings(deadline=None, max_examples=20)
@given(overrides=override_lists())
def test_points_equal_those_of_hydra(overrides: list[str], planner: Planner):
    assert outcome(planner, overrides) == outcome(by_hydra, overrides)


@settings(deadline=None, max_examples=20)
@given(overrides=plain_override_lists())
def test_assembled_points_equal_those_of_hydra(overrides: list[str], planner: Planner):
    assert outcome(planner, overrides) == outcome(by_hydra, overrides)


@pytest.mark.parametrize("override", UNUSUAL)
def test_an_unusual_override_has_the_same_effect_as_in_hydra(override: str, planner: Planner):
    assert outcome(planner, [override]) == outcome(by_hydra, [override])


# User options, some of which use features of Hydra that no shipped option uses.

CONSTANT = "_target_: rl_design_space.design.Constant\n"
SIGMOIDAL = "_target_: rl_design_space.design.Sigmoidal\n"
LENGTHS = "_target_: rl_design_space.design.MultiStepActions\n"
TORUS = "_target_: rl_design_space.design.Torus\n"
NOWHERE = "_target_: rl_design_space.tracking.NoTracking"
WALLED = "_target_: rl_design_space.design.Walled\n"
OWN = {
    "world/wide.yaml": f"{TORUS}size: [7, 4]\n",
    "world/torus.yaml": f"{TORUS}size: 6\n",  # has the name of one that is shipped
    "world/based.yaml": "defaults: [torus, _self_]\nsize: 12\n",
    "world/before_its_base.yaml": "defaults: [_self_, torus]\nsize: 12\n",
    "world/itself.yaml": f"defaults: [_self_]\n{TORUS}size: 5\n",
    "world/elsewhere.yaml": "# @package reward\nstep: -0.25\n",
    "world/own/nested.yaml": f"{WALLED}size: 9\n",
    "world/unfinished.yaml": f"{TORUS}size: ???\n",
    "world/partial.yaml": "size: 5\n",
    "world/empty.yaml": "",
    "world/list.yaml": "[torus, walled]\n",
    "world/unknown_key.yaml": f"{TORUS}size: 5\ndepth: {{of: 3}}\n",
    "world/of_all.yaml": f"# @package _global_\nworld: {{{WALLED.strip()}, size: 8}}\nreward: {{step: -0.5}}\n",
    "exploration/choosing.yaml": (
        "# @package _global_\ndefaults: [_self_, override /world: walled]\n"
        f"exploration: {{{CONSTANT.strip()}, epsilon: 0.2}}\n"
    ),
    "exploration/choosing_wrongly.yaml": f"defaults: [_self_, override /world: walled]\n{CONSTANT}epsilon: 0.2\n",
    "exploration/adding.yaml": f"defaults: [_self_, /reward@_global_.learner: end_reward]\n{CONSTANT}epsilon: 0.2\n",
    "exploration/by_size.yaml": f"{SIGMOIDAL}p: 3.0\nq: ${{world.size}}\n",
    "exploration/by_key.yaml": f"{SIGMOIDAL}p: 3.0\nq: ${{.p}}\n",
    "msa/by_goals.yaml": f"{LENGTHS}lengths: ['${{task.goals}}']\n",
    "msa/with_gamma.yaml": f"# @package _global_\nmsa: {{{LENGTHS.strip()}, lengths: [4]}}\nlearner: {{gamma: 0.5}}\n",
    # Settings are not options of a point, but their files may change points.
    "tracking/choosing.yaml": f"# @package _global_\ndefaults: [override /world: walled]\ntracking: {{{NOWHERE}}}\n",
    "tracking/of_all.yaml": f"# @package _global_\nreward: {{step: -0.75}}\ntracking: {{{NOWHERE}}}\n",
    "study/choosing.yaml": "# @package _global_\ndefaults: [override /world: walled]\nstudy: {blocks: {}}\n",
}


@pytest.fixture(scope="module")
def searchpath(tmp_path_factory: pytest.TempPathFactory) -> Overrides:
    folder = tmp_path_factory.mktemp("own options")
    for name, text in OWN.items():
        file = folder / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8")
    return [f"hydra.searchpath=['file://{folder}']"]


@pytest.fixture(scope="module")
def own_composer(searchpath: Overrides) -> Iterator[Planner]:
    with shipped_config():
        yield Planner(Composer(searchpath))


def own_option(file: str) -> str:
    """Return the override that chooses a file, e.g. `world/own/nested.yaml`."""
    group, _, option = file.removesuffix(".yaml").partition("/")
    return f"{group}={option}"


@pytest.mark.parametrize("file", OWN)
def test_a_user_option_has_the_same_effect_as_in_hydra(file: str, own_composer: Planner, searchpath: Overrides):
    overrides = [own_option(file)]
    assert outcome(own_composer, overrides) == outcome(lambda given: by_hydra(given, searchpath), overrides)


@pytest.mark.parametrize(
    "overrides",
    [
        ["exploration=choosing", "world=torus"],
        ["exploration=choosing", "tracking=of_all"],
        ["exploration=by_size", "world=wide", "world.size=3"],
        ["world=of_all", "reward=end_reward"],
        ["world=elsewhere", "reward=end_reward"],
        ["msa=with_gamma", "learner.gamma=0.25"],
        ["exploration=adding", "reward=each_success"],
        ["world=own/nested", "world.size=11", "task.goals=2"],
        ["world=list", "world.size=11"],
        ["msa=by_goals", "task.goals=4"],
    ],
    ids=" ".join,
)
def test_combinations_of_user_options_have_the_same_effect_as_in_hydra(
    overrides: list[str], own_composer: Planner, searchpath: Overrides
):
    assert outcome(own_composer, overrides) == outcome(lambda given: by_hydra(given, searchpath), overrides)


def test_user_options_of_this_file_describe_different_points(own_composer: Planner):
    # The others are refused, also by Hydra, or equal a shipped option.
    points = {own_option(file): outcome(own_composer, [own_option(file)]) for file in OWN}
    assert len({str(point) for point in points.values()}) > 12


# Whether points are assembled or composed.


@pytest.fixture
def composed(monkeypatch: pytest.MonkeyPatch) -> list[list[str]]:
    """Collect the overrides of every composition by Hydra."""
    calls: list[list[str]] = []
    original = hydra.compose

    def counted(name: str, overrides: list[str], **more: bool) -> object:
        calls.append(overrides)
        return original(name, overrides, **more)

    monkeypatch.setattr(hydra, "compose", counted)
    return calls


def test_plain_points_need_one_composition_in_total(composed: list[list[str]]):
    options = [f"{group}={file.stem}" for group, files in FILES.items() for file in files if group != "tracking"]
    # The first sees too little with the default representation, which has no blocks for the second.
    for other in ("msa=controllers", "curriculum=refine"):
        options.remove(other)
    values = ["seed=3", "task.goals=1", "world.size=[4,6]", "learner.gamma=0.5", "learner.ties=first", "outputs=there"]
    quoted = ["world='walled'", "exploration.epsilon=.5", "reward.step=-1e-1"]
    with shipped_config():
        planner = Planner()
        for overrides in [[], *([option, *values] for option in options), quoted, quoted[::-1]]:
            planner(overrides)
    assert composed == [[]]


def test_plain_user_options_need_no_further_composition(composed: list[list[str]], searchpath: Overrides):
    with shipped_config():
        planner = Planner(Composer(searchpath))
        for overrides in (["world=wide"], ["world=itself", "seed=1"], ["world=wide", "exploration=linear"]):
            planner(overrides)
    assert composed == [searchpath]


@pytest.fixture
def assembled(monkeypatch: pytest.MonkeyPatch) -> list[bool]:
    """Collect whether each point was assembled without Hydra."""
    found: list[bool] = []
    original = Assembler.__call__

    def watched(self: Assembler, overrides: Overrides) -> object:
        parts = original(self, overrides)
        found.append(parts is not None)
        return parts

    monkeypatch.setattr(Assembler, "__call__", watched)
    return found


@pytest.mark.parametrize(
    "override",
    [
        *("exploration=choosing", "exploration=adding", "exploration=by_size", "exploration=by_key", "msa=by_goals"),
        *("msa=with_gamma", "world=of_all", "world=elsewhere", "world=based", "world=unfinished", "world=none_such"),
        *("world.size=${seed}", "seed=${oc.decode:'5'}", "seed=???", "world.size=x", "++world.size=7", "~world.size"),
        *("+world.depth=1", "world.depth=1", "task={goals:2}", "world=[walled]", "world@reward=torus", "world=null"),
        *("seed=1,2", "nothing=1", "task.goals.of=1"),
    ],
)
def test_other_overrides_are_composed_by_hydra(override: str, own_composer: Planner, assembled: list[bool]):
    outcome(own_composer, [override])
    assert assembled == [False]
