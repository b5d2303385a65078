"""The command `rl-design-space`: a Hydra application."""

from __future__ import annotations

import sys

import hydra
from hydra.core.config_store import ConfigStore
from hydra.core.hydra_config import HydraConfig
from hydra.types import RunMode
from omegaconf import DictConfig

from rl_design_space._paths import CONF, make_plugins_known
from rl_design_space._version import __version__
from rl_design_space.commands import completion
from rl_design_space.commands.interrupts import handle_interrupts
from rl_design_space.commands.invocation import Invocation, current_invocation, running
from rl_design_space.commands.messages import shown_as_messages
from rl_design_space.config import user_config


def main() -> None:
    """Run the command; errors that a user can fix are shown as one message, with exit status 2."""
    from rl_design_space.commands import words

    handle_interrupts()
    if (completed := completion.answer(sys.argv[1:])) is not None:
        print(completed)
        return
    with shown_as_messages():
        folder, arguments = user_config.take_flag(sys.argv[1:])
        user_config.use(folder)
        if arguments[:1] and arguments[0] in words.names():
            words.run(arguments[0], arguments[1:])
        elif "--version" in arguments:
            print(f"rl-design-space {__version__}")
        elif {"-h", "--help"} & set(arguments):
            _show_help(arguments)
        else:
            _run(arguments)


@hydra.main(version_base="1.3", config_path=str(CONF), config_name="config")
def application(config: DictConfig) -> float:
    """Run one design point; Hydra's sweepers call it once per job.

    Returns:
        The objective of the point, see `objective` in conf/config.yaml.
    """
    invocation = current_invocation()
    invocation.jobs += 1
    if HydraConfig.get().mode == RunMode.MULTIRUN:
        return _run_point(config, invocation)
    # Show messages here as well: Hydra adds a line of its own to every exception that leaves a job.
    with shown_as_messages():
        return _run_point(config, invocation)


def _run(arguments: list[str]) -> None:
    """Run points, or show a configuration.

    Raises:
        ConfigError: the arguments contradict each other, or select no point.
        SystemExit: with status 1 if a point failed or records are pending.
    """
    from rl_design_space.commands.command_line import read_command_line
    from rl_design_space.config.search_path import look_in_user_folder_first

    make_plugins_known()
    line = read_command_line(arguments)
    if line.runs:
        user_config.tell_of_shadowing()
    look_in_user_folder_first()
    _share_config_store()
    sys.argv[1:] = line.for_hydra
    with running(Invocation(line)) as invocation:
        application()
    if line.foreign and not invocation.jobs:
        # Either the sweep is empty, or its launcher runs the jobs in other processes.
        from rl_design_space.commands.foreign_sweep import refuse_empty_sweep

        refuse_empty_sweep(line)
    if invocation.failed:
        sys.exit(1)


def _show_help(arguments: list[str]) -> None:
    """Print the help without composing a configuration; `--cfg job` shows a composed one."""
    from hydra._internal.utils import get_args_parser

    from rl_design_space.catalogue.overview import overview
    from rl_design_space.catalogue.search import searched
    from rl_design_space.commands import words
    from rl_design_space.config.overrides import is_search_path

    overrides = get_args_parser().parse_intermixed_args(arguments).overrides
    with searched(searchpath=list(filter(is_search_path, overrides))) as search:
        print(overview(search, words.summaries()), end="")


def _share_config_store() -> None:
    """Make Hydra share its store of built-in options, which it copies about a hundred times for `--help` otherwise.

    The store does not change once the plugins are loaded, and Hydra copies what it reads from it anyway.
    """
    ConfigStore.__deepcopy__ = lambda self, _: self  # type: ignore[attr-defined]


def _run_point(config: DictConfig, invocation: Invocation) -> float:
    from rl_design_space.commands.terminal import console, pending_line, point_table
    from rl_design_space.plan.planner import plan_composed
    from rl_design_space.run.objective import objective_value
    from rl_design_space.run.outcome import lost_record
    from rl_design_space.run.settings import build_settings
    from rl_design_space.run.single_point import run_point

    # A job may run in another process than `main`.
    user_config.use()
    run = HydraConfig.get()
    settings = build_settings(config)
    planned = plan_composed(config, run.runtime.choices, run.overrides.task)
    tracker = settings.tracking.open(invocation.command_or(planned.command))
    point_run = run_point(
        planned,
        tracker,
        settings.threads,
        lambda: console.print("waiting for another process, which is learning this point"),
    )
    delivery = tracker.wait_for_delivery()
    stored = tracker.finished([planned.fingerprint]).get(planned.fingerprint, point_run.stored)
    console.print(point_table(planned, stored, tracker.location, point_run.is_new))
    if delivery.lost:
        raise RuntimeError(lost_record(delivery.lost[planned.fingerprint]))
    if delivery.pending:
        console.print(pending_line(delivery, tracker.location), markup=False, soft_wrap=True)
        invocation.failed = True
    return objective_value(settings.objective, stored.scalars)
