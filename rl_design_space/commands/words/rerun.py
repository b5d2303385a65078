"""Learn the point of a recorded run again, and say whether the result is the same, bit by bit."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence


def main(arguments: Sequence[str]) -> None:
    """Compare a run with what its point gives now; exit with 1 if they differ.

    Raises:
        ConfigError: there is no such run, or it did not keep its periods.
    """
    parser = argparse.ArgumentParser(prog="rl-design-space rerun", description=__doc__)
    parser.add_argument("run_id", help="id of a run in MLflow, or its beginning")
    parser.add_argument("overrides", nargs="*", help="where it was recorded: outputs=… tracking.uri=…; threads=…")
    options = parser.parse_args(arguments)

    from rl_design_space.commands.terminal import console
    from rl_design_space.run.repeat import compare
    from rl_design_space.run.settings import settings_of

    settings = settings_of(options.overrides)
    comparison = compare(settings.tracking.reader(), options.run_id, settings.threads)
    console.print(comparison.text, markup=False, soft_wrap=True)
    sys.exit(0 if comparison.same else 1)
