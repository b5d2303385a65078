"""A sweep that tells what its parts cost: `python -m benchmarks.tracked …` ends with a line of JSON on stderr."""

from __future__ import annotations

import atexit
import json
import resource
import sys
from typing import Any

from rl_design_space.commands import cli, sweep_output
from rl_design_space.plan.plan import Plan
from rl_design_space.run.outcome import Outcome

_outcomes: list[Outcome] = []


def main() -> None:
    """Run the command; the CPU time of its children is that of the tracker process."""
    # Registered first, so called last: when the tracker process has ended.
    atexit.register(_report)
    show = sweep_output.show_outcome

    def noted(plan: Plan, outcome: Outcome, *arguments: Any) -> None:
        _outcomes.append(outcome)
        show(plan, outcome, *arguments)

    sweep_output.show_outcome = noted  # type: ignore[assignment]
    cli.main()


def _report() -> None:
    children = resource.getrusage(resource.RUSAGE_CHILDREN)
    (outcome,) = _outcomes
    figures = {
        "tracker_cpu": children.ru_utime + children.ru_stime,
        "learning": outcome.seconds["learning"],
        "moves": outcome.steps,
    }
    print(json.dumps(figures), file=sys.stderr)


if __name__ == "__main__":
    main()
