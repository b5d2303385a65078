"""Larger samples of the points of a study: the same designs with more periods, from a study of their own."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rl_design_space.config.compose import shipped_config
from rl_design_space.errors import ConfigError
from rl_design_space.plan.study import load_study
from rl_design_space.report.runs import Runs

if TYPE_CHECKING:
    from rl_design_space.plan.study import Study
    from rl_design_space.tracking.reader import Reader


def larger_samples(name: str, study: Study, reader: Reader) -> tuple[Runs, str]:
    """Return the points of a study with more periods, and the command that makes them.

    There are none if they cannot be planned under the overrides of the study that they are for.

    Args:
        name: of the study with more periods.
        study: that it has larger samples for.
        reader: of the tracked runs.

    Raises:
        ConfigError: there is no such study.
    """
    try:
        larger = study.another(name)
    except ConfigError:
        with shipped_config():
            load_study(name, ())
        return Runs([], reader), ""
    return Runs.of_study(larger, reader), larger.command
