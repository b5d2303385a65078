"""The command `rl-design-space`: a Hydra application."""

from __future__ import annotations

import sys
from typing import Any

import hydra
from hydra.core.hydra_config import HydraConfig
from omegaconf import DictConfig

from rl_design_space._paths import CONF
from rl_design_space.errors import ConfigError, shown_as_messages

#: Overrides of a study's points. They are meant for what the study's blocks choose, not for the defaults that
#: Hydra composes first, so they are kept from Hydra: `study=table4 exploration.k=0.05`.
_for_points: list[str] = []
_MULTIRUN = {"-m", "--multirun"}
#: Jobs that Hydra has started. It takes a sweep that matches nothing for a success.
_jobs = 0


def main() -> None:
    """Run the application; errors that a user can mend are one message and exit status 2."""
    from rl_design_space.sweep.arguments import check_arguments, split_arguments

    try:
        with shown_as_messages():
            check_arguments(sys.argv[1:])
            sys.argv[1:], _for_points[:] = split_arguments(sys.argv[1:])
            application()
            if not _jobs and _MULTIRUN & set(sys.argv):
                raise ConfigError("no design point in this sweep: one of its overrides matches nothing")
    except KeyboardInterrupt:
        print("interrupted; the same command goes on where this one stopped", file=sys.stderr)
        sys.exit(130)


@hydra.main(version_base="1.3", config_path=str(CONF), config_name="config")
def application(config: DictConfig) -> float | None:
    """Run one design point, or the points of a study."""
    global _jobs
    _jobs += 1
    run = HydraConfig.get()
    overrides = [*run.overrides.task, *_for_points]
    study = run.runtime.choices.get("study")
    # Here too, because Hydra adds a line of its own to every exception that leaves a job.
    with shown_as_messages():
        if not study:
            return _run_point(config, run.runtime.choices, overrides)
        _run_study(study, overrides)
    return None


def _run_point(config: DictConfig, choices: Any, overrides: list[str]) -> float:
    from rl_design_space.sweep.build import build_settings
    from rl_design_space.sweep.compose import planned_point
    from rl_design_space.sweep.run import run_point
    from rl_design_space.terminal import console, point_table

    settings = build_settings(config)
    planned = planned_point(config, choices, overrides)
    tracker = settings.tracking.open()
    stored, learned = run_point(planned, tracker, settings.threads)
    console.print(point_table(planned, stored, tracker.location, learned))
    return stored.scalars["total_steps"]


def _run_study(name: str, overrides: list[str]) -> None:
    from rl_design_space.sweep.build import build_settings
    from rl_design_space.sweep.run import run_sweep
    from rl_design_space.sweep.study import load_study
    from rl_design_space.terminal import SweepDisplay, console, failure_table

    study = load_study(name, overrides)
    settings = build_settings(study.config)
    tracker = settings.tracking.open()
    with SweepDisplay(name, len(study.plan)) as display:
        outcome = run_sweep(study, tracker, settings.threads, display.report)
    counts = outcome.counts
    console.print(
        f"study {name}: {len(study.plan)} points, {counts['done']} learned now, {counts['already']} before, "
        f"{counts['failed']} failed; in {tracker.location}",
        soft_wrap=True,
    )
    if outcome.failed:
        console.print(failure_table(study.plan, outcome.failed))
        sys.exit(1)
