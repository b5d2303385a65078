"""A sweep that tells what its parts cost: `python -m benchmarks.tracked …` ends with a line of JSON on stderr."""

from __future__ import annotations

import atexit
import json
import resource
import sys
from typing import Any

import rl_design_space.commands.sweep as command
from rl_design_space.commands import cli
from rl_design_space.run.runner import Outcome

_outcomes: list[Outcome] = []


def main() -> None:
    """Run the command; the CPU time of its children is that of the tracker process."""
    # Registered first, so called last: when the tracker process has ended.
    atexit.register(_report)
    close = command._close

    def noted(*arguments: Any) -> None:
        _outcomes.append(arguments[1])
        close(*arguments)

    command._close = noted  # type: ignore[assignment]
    cli.main()


def _report() -> None:
    children = resource.getrusage(resource.RUSAGE_CHILDREN)
    (outcome,) = _outcomes
    figures = {
        "tracker_cpu": children.ru_utime + children.ru_stime,
        "learning": outcome.seconds["learning"],
        "moves": outcome.moves,
    }
    print(json.dumps(figures), file=sys.stderr)


if __name__ == "__main__":
    main()
