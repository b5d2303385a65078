"""The Hydra application: one design point."""

from __future__ import annotations

from contextlib import chdir
from typing import Any

import hydra
from hydra.core.hydra_config import HydraConfig
from hydra.types import RunMode
from omegaconf import DictConfig, OmegaConf

from rl_design_space._paths import CONF
from rl_design_space.commands.invocation import Invocation, current_invocation
from rl_design_space.commands.messages import shown_as_messages
from rl_design_space.config import user_config
from rl_design_space.config.resolvers import register_resolvers

register_resolvers()


@hydra.main(version_base="1.3", config_path=str(CONF), config_name="config")
def application(config: DictConfig) -> float:
    """Run one design point; Hydra's sweepers call it once per job.

    Returns:
        The objective of the point, see `objective` in conf/config.yaml.
    """
    invocation = current_invocation()
    invocation.jobs += 1
    # Paths are relative to the folder of the command, also after `hydra.job.chdir=true`.
    with chdir(HydraConfig.get().runtime.cwd):
        if HydraConfig.get().mode == RunMode.MULTIRUN:
            return _run_point(config, invocation)
        # Show messages here as well: Hydra adds a line of its own to every exception that leaves a job.
        with shown_as_messages():
            return _run_point(config, invocation)


def _run_point(config: DictConfig, invocation: Invocation) -> float:
    from rl_design_space.commands.terminal import console, pending_line, point_table, run_table
    from rl_design_space.commands.unused_variables import tell_of_unused_variables
    from rl_design_space.plan.planner import plan_composed
    from rl_design_space.run.objective import objective_value, recorded_result
    from rl_design_space.run.outcome import lost_record
    from rl_design_space.run.settings import build_settings
    from rl_design_space.run.single_point import run_point

    # A job may run in another process than `main`.
    user_config.use()
    run = HydraConfig.get()
    overrides: Any = OmegaConf.to_container(run.overrides.task)  # with interpolations as they are
    settings = build_settings(config)
    if run.mode == RunMode.RUN:
        tell_of_unused_variables(settings.tracking)
    planned = plan_composed(config, run.runtime.choices, overrides)
    tracker = settings.tracking.open(invocation.command_or(planned.command))
    point_run = run_point(
        planned,
        tracker,
        settings.threads,
        lambda: console.print("waiting for another process, which is learning this point"),
    )
    # Its record is safe on disk; creating a database, or reaching a server, can take a while.
    console.print(point_table(planned, point_run.stored.scalars))
    delivery = tracker.wait_for_delivery()
    stored = tracker.finished([planned.fingerprint]).get(planned.fingerprint, point_run.stored)
    console.print(run_table(stored, tracker.location, point_run.is_new))
    if delivery.lost:
        raise RuntimeError(lost_record(delivery.lost[planned.fingerprint]))
    if delivery.pending:
        console.print(pending_line(delivery, tracker.location), markup=False, soft_wrap=True)
        invocation.failed = True
    if delivery.note:
        console.print(delivery.note, markup=False, soft_wrap=True)
    name = settings.objective
    result = point_run.result
    return objective_value(
        name, stored.scalars, lambda: result or recorded_result(name, settings.tracking, stored, planned.point)
    )
