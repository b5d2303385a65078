"""A study planned from its blocks."""

from __future__ import annotations

from typing import Any

import pytest
from omegaconf import OmegaConf

from rl_design_space.plan.plan import Plan
from rl_design_space.plan.planner import Planner
from rl_design_space.plan.study import plan_study


@pytest.fixture
def planned(planner: Planner):
    """Plan a study with these blocks, named `mine`."""

    def plan(blocks: Any, *overrides: str, name: str = "mine", **more: Any) -> Plan:
        return plan_study(name, OmegaConf.create({"study": {"blocks": blocks, **more}}), overrides, planner)

    return plan
