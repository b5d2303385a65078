"""The command `rl-design-space`: a Hydra application."""

from __future__ import annotations

import signal
import sys
from typing import TYPE_CHECKING

import hydra
from hydra.core.config_store import ConfigStore
from hydra.core.hydra_config import HydraConfig
from hydra.types import RunMode
from omegaconf import DictConfig

from rl_design_space._paths import CONF, make_plugins_known
from rl_design_space.errors import ConfigError, shown_as_messages

if TYPE_CHECKING:
    from rl_design_space.sweep.arguments import CommandLine

#: What was typed; our sweeper asks for it.
command_line: CommandLine | None = None
#: Jobs that sweepers of Hydra have had run. They take a sweep that matches nothing for a success.
jobs = 0
#: Whether results wait to be told to a store that takes nothing.
unsettled = False


def main() -> None:
    """Run the application; errors that a user can mend are one message and exit status 2."""
    global command_line
    from rl_design_space import commands

    if sys.argv[1:2] and sys.argv[1] in commands.words():
        with shown_as_messages():
            commands.run(sys.argv[1], sys.argv[2:])
        return
    from rl_design_space.sweep.arguments import read_command_line

    make_plugins_known()
    # A job that is told to end, by a cluster for instance, ends as one that is interrupted: nothing is lost.
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        with shown_as_messages():
            command_line = read_command_line(sys.argv[1:])
            _keep_options_in_one_copy()
            sys.argv[1:] = command_line.for_hydra
            application()
            if not jobs and command_line.foreign:
                raise ConfigError("no design point in this sweep: one of its overrides matches nothing")
        if unsettled:
            sys.exit(1)
    except KeyboardInterrupt:
        print("interrupted; the same command goes on where this one stopped", file=sys.stderr)
        sys.exit(130)


@hydra.main(version_base="1.3", config_path=str(CONF), config_name="config")
def application(config: DictConfig) -> float:
    """Run one design point; the sweepers of Hydra call it for each of theirs.

    Returns:
        The objective of the point, see `objective` in conf/config.yaml.
    """
    global jobs
    jobs += 1
    if HydraConfig.get().mode == RunMode.MULTIRUN:
        return _run_point(config)
    # Here too, because Hydra adds a line of its own to every exception that leaves a job.
    with shown_as_messages():
        return _run_point(config)


def _keep_options_in_one_copy() -> None:
    """Let Hydra share its store of built-in options instead of copying it a hundred times for `--help`.

    Nothing changes the store once the plugins are loaded, and what is read from it is copied anyway.
    """
    ConfigStore.__deepcopy__ = lambda self, _: self  # type: ignore[attr-defined]


def _run_point(config: DictConfig) -> float:
    global unsettled
    from rl_design_space.sweep.build import build_settings
    from rl_design_space.sweep.compose import parts_of, planned_point
    from rl_design_space.sweep.objective import objective_value
    from rl_design_space.sweep.run import run_point
    from rl_design_space.terminal import awaiting_line, console, point_table

    run = HydraConfig.get()
    settings = build_settings(config)
    planned = planned_point(parts_of(config, run.runtime.choices), run.overrides.task)
    tracker = settings.tracking.open(command_line.command if command_line else planned.command)
    stored, learned = run_point(
        planned,
        tracker,
        settings.threads,
        lambda: console.print("another process is at this point; waiting for it"),
    )
    settled = tracker.settle()
    stored = tracker.finished([planned.fingerprint]).get(planned.fingerprint, stored)
    console.print(point_table(planned, stored, tracker.location, learned))
    if settled.lost:
        raise RuntimeError(f"its record {settled.lost[planned.fingerprint]}")
    if settled.awaiting:
        console.print(awaiting_line(settled, tracker), markup=False, soft_wrap=True)
        unsettled = True
    return objective_value(settings.objective, stored.scalars)
