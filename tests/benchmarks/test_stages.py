"""Cost of stages beside that of their steps."""

from __future__ import annotations

from benchmarks.stages import CASES, cost


def test_a_point_with_stages_is_compared_with_the_steps_that_it_makes():
    seconds, of_its_steps = cost(CASES[0], ["task.periods=2", "task.trials=3"], turns=2)
    assert seconds > 0
    assert of_its_steps > 0
