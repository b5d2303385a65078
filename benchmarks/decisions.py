"""How many decisions a move takes when actions are several moves long.

Learning curves count moves. So the kernel is run once more as plain Python, with the compiler switched off, and the
updates of executed actions are counted. It uses the same random numbers and makes the same moves as the compiled one,
which is checked, so the count is exact for these periods; for others, it gives the mean number of decisions a move.
"""

from __future__ import annotations

import json
import os
import sys
import warnings

import numpy as np

from benchmarks.processes import run
from rl_design_space.design import DesignPoint, Linear, MultiStepActions, Task


def point(lengths: tuple[int, ...], periods: int, seed: int) -> DesignPoint:
    """The paper's default with linear ε and these multi-step actions."""
    return DesignPoint(
        seed=seed, task=Task(periods=periods), exploration=Linear(), msa=MultiStepActions(lengths=lengths)
    )


def decisions_per_move(lengths: tuple[int, ...], periods: int, seed: int = 0) -> float:
    """Decisions a move, averaged over all moves of some periods.

    Raises:
        RuntimeError: the plain kernel did not do what the compiled one does.
    """
    from rl_design_space.learning import simulate

    arguments = json.dumps([lengths, periods, seed])
    plain = {**os.environ, "NUMBA_DISABLE_JIT": "1"}
    counted = json.loads(run([sys.executable, "-m", "benchmarks.decisions", arguments], plain).stdout)
    compiled = simulate(point(lengths, periods, seed), threads=1).total_steps
    if counted["moves"] != compiled.tolist():
        raise RuntimeError(f"lengths {lengths}: the plain and the compiled kernel make different moves")
    return float(counted["decisions"] / np.sum(counted["moves"]))


def _count(lengths: list[int], periods: int, seed: int) -> dict[str, object]:
    from rl_design_space.learning import kernel, simulate

    keep = vars(kernel)["keep"]
    decisions = 0

    def counted(numbers: object, reals: object, values: object, q: object, running: int, some_seen: bool) -> object:
        nonlocal decisions
        decisions += running
        return keep(numbers, reals, values, q, running, some_seen)

    vars(kernel)["keep"] = counted
    with warnings.catch_warnings():
        # 64-bit words overflow on purpose.
        warnings.simplefilter("ignore", RuntimeWarning)
        curves = simulate(point(tuple(lengths), periods, seed), threads=1)
    return {"decisions": decisions, "moves": curves.total_steps.tolist()}


if __name__ == "__main__":
    print(json.dumps(_count(*json.loads(sys.argv[1]))))
