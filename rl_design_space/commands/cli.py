"""The command `rl-design-space`: a Hydra application."""

from __future__ import annotations

import signal
import sys

import hydra
from hydra.core.config_store import ConfigStore
from hydra.core.hydra_config import HydraConfig
from hydra.types import RunMode
from omegaconf import DictConfig

from rl_design_space._paths import CONF, make_plugins_known
from rl_design_space.commands.invocation import Invocation, current_invocation, running
from rl_design_space.commands.messages import shown_as_messages
from rl_design_space.config import user_config
from rl_design_space.errors import ConfigError


def main() -> None:
    """Run the application; errors that a user can fix are one message and exit status 2."""
    from rl_design_space.commands import words

    with shown_as_messages():
        folder, arguments = user_config.take_flag(sys.argv[1:])
        user_config.use(folder)
        if arguments[:1] and arguments[0] in words.names():
            words.run(arguments[0], arguments[1:])
        elif {"-h", "--help"} & set(arguments):
            _show_help(arguments)
        else:
            _run(arguments)


@hydra.main(version_base="1.3", config_path=str(CONF), config_name="config")
def application(config: DictConfig) -> float:
    """Run one design point; the sweepers of Hydra call it for each of theirs.

    Returns:
        The objective of the point, see `objective` in conf/config.yaml.
    """
    invocation = current_invocation()
    invocation.jobs += 1
    if HydraConfig.get().mode == RunMode.MULTIRUN:
        return _run_point(config, invocation)
    # Here too, because Hydra adds a line of its own to every exception that leaves a job.
    with shown_as_messages():
        return _run_point(config, invocation)


def _run(arguments: list[str]) -> None:
    """Run points, or show a configuration.

    Raises:
        ConfigError: the arguments do not go together, or ask for nothing.
        SystemExit: with status 1 if a point failed or results are not delivered, with 130 after Ctrl-C.
    """
    from rl_design_space.commands.command_line import read_command_line
    from rl_design_space.config.search_path import look_in_user_folder_first

    make_plugins_known()
    # A job that is told to end, by a cluster for instance, ends as one that is interrupted: nothing is lost.
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        line = read_command_line(arguments)
        if line.runs:
            user_config.tell_of_shadowing()
        look_in_user_folder_first()
        _keep_options_in_one_copy()
        sys.argv[1:] = line.for_hydra
        with running(Invocation(line)) as invocation:
            application()
        if not invocation.jobs and line.foreign:
            raise ConfigError("no design point in this sweep: one of its overrides matches nothing")
        if invocation.undelivered:
            sys.exit(1)
    except KeyboardInterrupt:
        print("interrupted; the same command goes on where this one stopped", file=sys.stderr)
        sys.exit(130)


def _show_help(arguments: list[str]) -> None:
    """Answer `--help` without composing anything; what is composed, `--cfg job` shows."""
    from hydra._internal.utils import get_args_parser

    from rl_design_space.catalogue.overview import overview
    from rl_design_space.catalogue.search import searched
    from rl_design_space.commands import words

    overrides = get_args_parser().parse_intermixed_args(arguments).overrides
    searchpath = [override for override in overrides if override.lstrip("+").startswith("hydra.searchpath=")]
    with searched(searchpath=searchpath) as search:
        print(overview(search, words.summaries()), end="")


def _keep_options_in_one_copy() -> None:
    """Let Hydra share its store of built-in options instead of copying it a hundred times for `--help`.

    Nothing changes the store once the plugins are loaded, and what is read from it is copied anyway.
    """
    ConfigStore.__deepcopy__ = lambda self, _: self  # type: ignore[attr-defined]


def _run_point(config: DictConfig, invocation: Invocation) -> float:
    from rl_design_space.commands.terminal import console, pending_line, point_table
    from rl_design_space.plan.planner import plan_composed
    from rl_design_space.run.objective import objective_value
    from rl_design_space.run.runner import run_point
    from rl_design_space.run.settings import build_settings

    # A job may run in a process of its own.
    user_config.use()
    run = HydraConfig.get()
    settings = build_settings(config)
    planned = plan_composed(config, run.runtime.choices, run.overrides.task)
    tracker = settings.tracking.open(invocation.command_or(planned.command))
    stored, learned = run_point(
        planned,
        tracker,
        settings.threads,
        lambda: console.print("another process is at this point; waiting for it"),
    )
    delivery = tracker.wait_for_delivery()
    stored = tracker.finished([planned.fingerprint]).get(planned.fingerprint, stored)
    console.print(point_table(planned, stored, tracker.location, learned))
    if delivery.lost:
        raise RuntimeError(f"its record {delivery.lost[planned.fingerprint]}")
    if delivery.pending:
        console.print(pending_line(delivery, tracker), markup=False, soft_wrap=True)
        invocation.undelivered = True
    return objective_value(settings.objective, stored.scalars)
