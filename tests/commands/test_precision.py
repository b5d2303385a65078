"""A sweep that asks for a precision, on the command line."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from rl_design_space.commands.race import race_looks
from rl_design_space.errors import ConfigError
from rl_design_space.plan.plan import Plan
from rl_design_space.run.settings import settings_of
from tests.command_runner import commands_in
from tests.points import planned_point

ASKING = (
    "rl-design-space", "-m", "task.periods=20", "task.trials=5", "world.size=4,5", "task.precision=0.2",
    "task.periods_at_most=60",
)  # fmt: skip


def test_a_sweep_learns_until_its_means_are_precise(empty_database: Path, tmp_path: Path):
    command = commands_in(tmp_path, empty_database)
    lines = command(*ASKING).stdout.splitlines()
    assert re.fullmatch(
        r"precision reached by [012] of 2 points, with \d+( to \d+)? periods(; the others .*)?", lines[-2]
    )
    assert lines[-1].startswith("sweep: 2 points, 2 learned now")
    # A repeated command learns nothing; another precision begins with what is recorded.
    again = command(*ASKING).stdout.splitlines()
    assert again[-2] == lines[-2]
    assert again[-1].startswith("sweep: 2 points, 0 learned now, 2 before")
    smaller = command(*ASKING[:-2], "task.precision=0.1", "plan=true").stdout
    assert "0 recorded already, 2 to run" in smaller
    assert "- 2 ask for a precision: that is the time of task.periods, " in smaller
    assert "- 2 begin with periods that are recorded" in smaller


def test_a_race_decides_itself_how_many_periods_a_point_gets():
    plan = Plan([planned_point(["task.precision=0.2"])])
    with pytest.raises(ConfigError, match=r"^task\.precision=0\.2: a race decides itself how many periods"):
        race_looks(plan, settings_of(["tracking=none"]), None, {})
