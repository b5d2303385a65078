"""A setting means the same in a file and on the command line: in single runs, sweeps, plans and shards."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import pytest
import yaml
from hydra._internal.config_loader_impl import ConfigLoaderImpl
from hydra._internal.utils import get_args_parser
from hydra.core.global_hydra import GlobalHydra
from hydra.types import RunMode
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st
from omegaconf import DictConfig, OmegaConf

from rl_design_space._paths import make_plugins_known
from rl_design_space.commands.command_line import CommandLine, read_command_line
from rl_design_space.commands.sweep import plan_sweep
from rl_design_space.config import user_config
from rl_design_space.config.compose import shipped_config
from rl_design_space.errors import ConfigError
from rl_design_space.plan.plan import Plan
from rl_design_space.plan.planner import plan_composed
from rl_design_space.run.settings import build_settings

#: Settings and values as a file has them, by their overrides of the command line.
SETTINGS: dict[str, Mapping[str, Any]] = {
    "outputs=elsewhere": {"outputs": "elsewhere"},
    "outputs='of_${world.size}'": {"outputs": "of_${world.size}"},
    "threads=1": {"threads": 1},
    "objective=failed_trials": {"objective": "failed_trials"},
    "on_error=stop": {"on_error": "stop"},
    "plan=true": {"plan": True},
    "shard=2/2": {"shard": "2/2"},
    "tracking=none": {"defaults": [{"override /tracking": "none"}]},
    "study=small": {"defaults": [{"override /study": "small"}]},
    "seed=3": {"seed": 3},
    "world=walled": {"defaults": [{"override /world": "walled"}]},
    "world.size=4": {"world": {"size": 4}},
    "exploration=linear": {"defaults": [{"override /exploration": "linear"}]},
    "task={goals: 1, max_steps: 50}": {"task": {"goals": 1, "max_steps": 50}},
    "hydra.mode=MULTIRUN": {"hydra": {"mode": "MULTIRUN"}},
    "hydra/sweeper=basic": {"defaults": [{"override /hydra/sweeper": "basic"}]},
    "+hydra.sweeper.params.seed='1,2'": {"hydra": {"sweeper": {"params": {"seed": "1,2"}}}},
    "hydra/launcher=design_dask": {"defaults": [{"override /hydra/launcher": "design_dask"}]},
    "hydra.launcher.dumps=true": {"hydra": {"launcher": {"dumps": True}}},
    "+hydra.job.env_set.NAME=value": {"hydra": {"job": {"env_set": {"NAME": "value"}}}},
}
#: Other files of the user's config folder.
FILES = {
    # Its blocks take precedence over values of files, as sweeps do, so it has other keys than the settings above.
    "study/small.yaml": "blocks: {a: {learner.gamma: '0.8,0.9'}, b: {learner.gamma: '0.9,0.95'}}",
    "study/recording.yaml": "blocks: {a: {seed: '1,2', tracking: none}}",
    "study/walled.yaml": "# @package _global_\ndefaults: [override /world: walled]\nstudy: {blocks: {a: {seed: 1}}}",
    "other.yaml": "defaults: [config, setup: tiny, _self_]\nseed: 9",
    "setup/tiny.yaml": "# @package _global_\nworld: {size: 10}",  # the size of the default option, not of another one
    "world/large.yaml": "_target_: rl_design_space.design.Torus\nsize: 20",
    "setup/nested/quick.yaml": "# @package _global_\ntask: {trials: 5}",
    "setup/nowhere.yaml": "# @package _global_\ndefaults: [override /tracking: none]",
    "setup/nameless.yaml": "# @package _global_\nstudy: {blocks: {a: {seed: '1,2'}}}",
    "setup/searching.yaml": "# @package _global_\nhydra: {sweeper: {params: {seed: '1,2'}}}",
    "setup/misplaced.yaml": "# @package _global_\nhydra: {sweeper: {params: {threads: 1}}}",
    "setup/misspelt.yaml": "# @package _global_\nhydra: {sweeper: {parms: {seed: '1,2'}}}",
    "setup/listed.yaml": "# @package _global_\nhydra: {sweeper: {params: {seed: [1, 2]}}}",
}
ALL = tuple(SETTINGS)
SWEEP = ("-m", "task.trials=3,4", "learner.alpha=0.2")
COMMANDS = ((), SWEEP, ("plan=true", "seed=5"), ("shard=1/2", *SWEEP), (*SWEEP, "hydra/sweeper=basic"))


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """Use a config folder of the user's, and restore the process state afterwards."""
    make_plugins_known()
    folder = tmp_path_factory.mktemp("settings") / "conf"
    for name, text in FILES.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(f"{text}\n", encoding="utf-8")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(user_config.VARIABLE, str(folder))
        yield folder


@contextmanager
def composed(*arguments: str) -> Iterator[tuple[CommandLine, RunMode, DictConfig, ConfigLoaderImpl]]:
    """Compose the config of a command line as Hydra does."""
    line = read_command_line(arguments)
    flags = get_args_parser().parse_intermixed_args(line.for_hydra)
    mode = RunMode.MULTIRUN if flags.multirun or line.foreign else RunMode.RUN
    with shipped_config():
        loader = cast(ConfigLoaderImpl, GlobalHydra.instance().config_loader())
        yield line, mode, loader.load_configuration(flags.config_name or "config", flags.overrides, mode), loader


def planned(line: CommandLine, config: DictConfig) -> Plan:
    return plan_sweep(line.overrides, config.hydra.sweeper.get("params") or {}, config, build_settings(config))


def meaning(*arguments: str) -> object:
    """Return all that a command line says about a run or a sweep; or that it is refused."""
    try:
        with composed(*arguments) as (line, mode, config, _):
            if mode == RunMode.RUN or line.foreign:
                points = [plan_composed(config, config.hydra.runtime.choices, ()).fingerprint]
            else:
                points = [point.fingerprint for point in planned(line, config)]
            settings = build_settings(config)
    except ConfigError:
        return "refused"
    hydra: Any = OmegaConf.to_container(config.hydra)
    return mode, line.foreign, settings, hydra["sweeper"], hydra["launcher"], hydra["job"]["env_set"], points


def write_setup(folder: Path, contents: Sequence[Mapping[str, Any]], name: str = "mine") -> None:
    """Write contents into one file, which applies to the whole config."""
    defaults = [choice for content in contents for choice in content.get("defaults", ())]
    merged: Any = OmegaConf.merge(
        *[{key: content[key] for key in content if key != "defaults"} for content in contents]
    )
    text = yaml.safe_dump({"defaults": defaults, **OmegaConf.to_container(merged)})
    (folder / "setup" / f"{name}.yaml").write_text(f"# @package _global_\n{text}", encoding="utf-8")


@settings(deadline=None, max_examples=3)
@given(chosen=st.lists(st.sampled_from(ALL), min_size=1, max_size=5, unique=True), command=st.sampled_from(COMMANDS))
@example(chosen=["hydra/sweeper=basic", "hydra.mode=MULTIRUN", "tracking=none"], command=())
@example(chosen=["study=small", "exploration=linear", "outputs=elsewhere"], command=("exploration.k=0.05",))
def test_a_setting_in_a_file_equals_that_of_the_command_line(chosen: list[str], command: tuple[str, ...], folder: Path):
    # Hydra's own sweeper has no params that the command line could add to.
    assume(not {"hydra/sweeper=basic", "+hydra.sweeper.params.seed='1,2'"} <= {*chosen, *command})
    write_setup(folder, [SETTINGS[override] for override in chosen])
    assert meaning("+setup=mine", *command) == meaning(*chosen, *command)


@pytest.mark.parametrize(
    ("arguments", "points"),
    [
        ("-m --config-name other world=torus,large", 1),  # tiny applies to both
        ("-m +setup=nested/quick,tiny world=walled,large", 4),
        ("plan=true +setup=searching world.size=${seed} seed=7,8 hydra.sweep.subdir=${hydra.job.num}", 2),
        ("-m +setup=nowhere tracking=none outputs=of_${task.goals} task.goals=2 seed=1,2", 2),
        ("study=walled seed=3,4", 2),
    ],
)
def test_points_and_settings_are_those_of_hydra(arguments: str, points: int, folder: Path):
    with composed(*arguments.split()) as (line, _, config, loader):
        plan = planned(line, config)
        assert len(plan) == points
        for point in plan:
            job = loader.load_sweep_config(config, list(point.overrides))
            assert plan_composed(job, job.hydra.runtime.choices, ()).fingerprint == point.fingerprint
            assert replace(build_settings(job), plan=False) == replace(build_settings(config), plan=False)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ("-m +setup=nowhere,tiny", "tracking=none: a setting applies to the whole sweep; tracking=sqlite outside of"),
        ("-m outputs=of_${seed} seed=1,2", "outputs=of_1: a setting applies to the whole sweep; outputs=of_0 outside"),
        (
            "-m +setup=misplaced",
            "hydra.sweeper.params.threads=1: a setting applies to the whole sweep; write it beside",
        ),
        (
            "study=recording",
            "study recording, block a: tracking=none: a setting applies to the whole sweep; give it on",
        ),
        ("+setup=misspelt", "hydra.sweeper.parms: no such key in DesignSweeper; did you mean hydra.sweeper.params?"),
        ("+hydra.launcher.dump=true", "hydra.launcher.dump: no such key in DesignLauncher; did you mean hydra.launch"),
        (
            "-m +setup=listed",
            "seed=[1, 2]: should be a valid integer, not a list; values without brackets make a sweep: seed=1,2, in a "
            'file seed: "1,2"',
        ),
        ("-m shard=0 seed=1,2", "shard=0: should be i/N, from 1/N to N/N"),
        ("+setup=nameless", "study: has no name; write it to study/NAME.yaml"),
        ("plan=true --config-name other hydra/sweeper=basic", "plan=true needs hydra/sweeper=design, not basic"),
    ],
)
def test_what_does_not_apply_to_all_points_is_refused_by_its_key(arguments: str, message: str, folder: Path):
    with (
        pytest.raises(ConfigError, match=f"^{re.escape(message)}"),
        composed(*arguments.split()) as (line, _, config, _),
    ):
        planned(line, config)
