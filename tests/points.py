"""Points and studies of the shipped configuration, planned with one composer.

Composing takes Hydra 0.1 s, and a composer keeps what it has composed.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import cache

from rl_design_space.config.compose import Composer, shipped_config
from rl_design_space.plan.plan import PlannedPoint
from rl_design_space.plan.planner import Planner
from rl_design_space.plan.study import Study, load_study


@contextmanager
def planning() -> Iterator[Planner]:
    """Initialize Hydra with the shipped configuration, and give a planner that uses what is composed already."""
    with shipped_config():
        yield Planner(_composer())


def planned_point(overrides: Sequence[str] = ()) -> PlannedPoint:
    """Plan the point that these overrides describe."""
    with planning() as planner:
        return planner(overrides)


@cache
def shipped_study(name: str, *overrides: str) -> Study:
    """Plan a shipped study, or return it as it was planned before."""
    with shipped_config():
        return load_study(name, overrides, _planner())


@cache
def _planner() -> Planner:
    """The planner of all shipped studies, so that those that several include are planned once."""
    return Planner(_composer())


@cache
def _composer() -> Composer:
    """The composer of all tests; Hydra has to be initialized."""
    return Composer()
