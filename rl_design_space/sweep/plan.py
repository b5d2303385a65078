"""A planned point: a design point and how it was asked for."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from rl_design_space.design import DesignPoint
from rl_design_space.sweep.build import is_setting
from rl_design_space.sweep.describe import parameters
from rl_design_space.sweep.fingerprint import fingerprint


@dataclass(frozen=True)
class PlannedPoint:
    """A design point and how it was asked for.

    Attributes:
        point: the point itself.
        options: name of the chosen option of every config group, e.g. {"world": "torus"}.
        overrides: the command-line overrides that describe the point.
        studies: names of the studies that the point belongs to.
    """

    point: DesignPoint
    options: Mapping[str, str]
    overrides: tuple[str, ...] = ()
    studies: tuple[str, ...] = ()

    @cached_property
    def fingerprint(self) -> str:
        """The point's identity, see `sweep.fingerprint`."""
        return fingerprint(self.point)

    @property
    def parameters(self) -> dict[str, Any]:
        """Every choice by its name on the command line: options first, then values."""
        return {**self.options, **parameters(self.point)}

    @property
    def name(self) -> str:
        """A short description: what was asked for beside the defaults."""
        return " ".join(override for override in self.overrides if not is_setting(override)) or "defaults"

    @property
    def command(self) -> str:
        """The command that runs this point alone."""
        return shlex.join(["rl-design-space", *self.overrides])
