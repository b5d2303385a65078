"""Re-run a recorded point, and compare the results bit for bit."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from rl_design_space.commands.arguments import Parser


def main(arguments: Sequence[str]) -> None:
    """Compare a recorded run with a new run of its point; exit with status 1 if they differ.

    Raises:
        ConfigError: no run or several runs match, or the run does not hold its periods.
    """
    parser = Parser(prog="rl-design-space rerun", description=__doc__)
    parser.add_argument("run_id", help="id of a run in MLflow, or a prefix of it")
    parser.add_argument(
        "overrides",
        nargs="*",
        help="settings, e.g. outputs=DIR, tracking.uri=URI or threads=N",
    )
    options = parser.parse_args(arguments)

    from rl_design_space.commands.terminal import console
    from rl_design_space.run.repeat import compare
    from rl_design_space.run.settings import reading_settings_of

    settings = reading_settings_of(options.overrides)
    comparison = compare(settings.tracking.reader(), options.run_id, settings.threads)
    console.print(comparison.text, markup=False, soft_wrap=True)
    sys.exit(0 if comparison.same else 1)
