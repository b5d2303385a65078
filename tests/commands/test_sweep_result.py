"""What a sweep prints at its end, from recorded scalars alone; and progress."""

from __future__ import annotations

import math
from itertools import product

from rl_design_space.commands import watching
from rl_design_space.commands.sweep_result import result_lines
from rl_design_space.commands.watching import counting, watched
from rl_design_space.plan.plan import Plan
from rl_design_space.tracking.tracker import StoredRun
from tests.points import planned_point

STEPS = {"ad_hoc": 4000.0, "direction": 6000.0}
REWARDS = {"many_rewards": 1.0, "each_success": 1.05, "end_reward": 2.5}


def planned(name: str, reward: str, seed: int = 0):
    return planned_point(["world.size=4", f"representation={name}", f"reward={reward}", f"seed={seed}"])


def swept(error: float, seeds: int = 1) -> tuple[Plan, dict[str, StoredRun]]:
    points = {(n, r, s): planned(n, r, s) for n, r, s in product(STEPS, REWARDS, range(seeds))}
    stored = {
        point.fingerprint: StoredRun("id", scalars={"total_steps": STEPS[n] * REWARDS[r], "total_steps_sem": error})
        for (n, r, _), point in points.items()
    }
    return Plan(tuple(points.values()), studies=("mine",)), stored


def test_a_sweep_ends_with_its_best_designs_their_ties_and_what_mattered():
    plan, stored = swept(90.0)
    lines = result_lines(plan, stored, ["outputs=my out"])
    assert lines[0] == "fewest total steps of 6 designs, ± 95 % of each by itself:"
    assert [line[:15] for line in lines[1:7]] == [
        "  ≈ 4,000 ± 176", "  ≈ 4,200 ± 176", "    6,000 ± 176",
        "    6,300 ± 176", "    10,000 ± 17", "    15,000 ± 17",
    ]  # fmt: skip
    assert lines[1].endswith("  representation=ad_hoc reward=many_rewards")
    assert lines[7].startswith("≈ 2 designs cannot be told from the best")
    logs = [math.log(factor) for factor in REWARDS.values()]
    reward = sum(log**2 for log in logs) / 3 - (sum(logs) / 3) ** 2
    representation = math.log(1.5) ** 2 / 4
    share = reward / (reward + representation)
    assert f"mattered most for log(total steps): reward {share:.0%} (with" in lines[8]
    assert "representation" in lines[8]
    assert lines[8].endswith("; the report `importance` is of log(steps / optimum), period by period")
    assert lines[9:] == [
        "more: rl-design-report best --study=mine 'outputs=my out'",
        "more: rl-design-report importance --study=mine 'outputs=my out'",
    ]


def test_seeds_are_averaged_and_a_single_design_has_no_result():
    plan, stored = swept(90.0, seeds=4)
    assert result_lines(plan, stored)[1].startswith("    4,000 ± 88  representation=ad_hoc")
    one = Plan((planned("ad_hoc", "end_reward"), planned("ad_hoc", "end_reward", 1)))
    assert result_lines(one, stored) == []
    assert result_lines(plan, {}) == []


def test_a_sweep_without_a_clear_difference_says_so():
    plan, stored = swept(5000.0)
    told = "mattered most for log(total steps): nothing can be told from noise"
    assert any(line.startswith(told) for line in result_lines(plan, stored))


def test_steps_that_take_a_second_are_shown_in_a_terminal(monkeypatch, capsys):
    assert list(watched(range(3), "counting")) == [0, 1, 2]
    seconds = iter([0.0, 0.5, 2.0, 3.0])
    monkeypatch.setattr(watching, "monotonic", lambda: next(seconds))
    monkeypatch.setattr("sys.stderr.isatty", lambda: True, raising=False)
    monkeypatch.setenv("TERM", "xterm")
    with counting("reading runs", 3) as count:
        count()
        assert capsys.readouterr().err == ""
        count()
        count()
    assert "reading runs" in capsys.readouterr().err
