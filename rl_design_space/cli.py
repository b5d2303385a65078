"""The command `rl-design-space`: a Hydra application."""

from __future__ import annotations

import os
import shlex
import sys
from typing import Any

import hydra
from hydra.core.hydra_config import HydraConfig
from omegaconf import DictConfig

from rl_design_space._paths import CONF

_FULL_ERROR = "HYDRA_FULL_ERROR"


def main() -> None:
    """Run the application; errors that a user can mend are one message and exit status 2."""
    wants_traceback = os.environ.get(_FULL_ERROR, "0") not in ("", "0")
    # With this set, Hydra hands errors on instead of printing them and exiting with 1.
    os.environ[_FULL_ERROR] = "1"
    try:
        application()
    except KeyboardInterrupt:
        sys.exit("interrupted; the same command goes on where this one stopped")
    except Exception as error:
        from rl_design_space.sweep.explain import explain

        explained = explain(error)
        if wants_traceback or explained is None:
            raise
        print(f"error: {explained}", file=sys.stderr)
        sys.exit(2)


@hydra.main(version_base="1.3", config_path=str(CONF), config_name="config")
def application(config: DictConfig) -> float | None:
    """Run one design point, or the points of a study."""
    run = HydraConfig.get()
    overrides = list(run.overrides.task)
    study = run.runtime.choices.get("study")
    if not study:
        return _run_point(config, run.runtime.choices, overrides)
    _run_study(study, config, overrides)
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


def _run_study(name: str, config: DictConfig, overrides: list[str]) -> None:
    from rl_design_space.sweep.build import build_settings
    from rl_design_space.sweep.compose import Composer
    from rl_design_space.sweep.run import run_sweep
    from rl_design_space.sweep.study import plan_study
    from rl_design_space.terminal import SweepDisplay, console, failure_table

    settings = build_settings(config)
    plan = plan_study(name, config, overrides, Composer())
    tracker = settings.tracking.open()
    command = shlex.join(["rl-design-space", *sys.argv[1:]])
    with SweepDisplay(name, len(plan)) as display:
        outcome = run_sweep(name, command, plan, tracker, settings.threads, display.report)
    counts = outcome.counts
    console.print(
        f"study {name}: {len(plan)} points, {counts['done']} learned now, {counts['already']} before, "
        f"{counts['failed']} failed; in {tracker.location}"
    )
    if outcome.failed:
        console.print(failure_table(plan, outcome.failed))
        sys.exit(1)
