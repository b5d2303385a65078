"""A period of a design point, learned again to be looked at."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from rl_design_space._arrays import FloatArray
from rl_design_space.analysis.snapshot import Snapshot, chosen_period, chosen_trial, snapshot
from rl_design_space.design import DesignPoint
from rl_design_space.errors import ConfigError
from rl_design_space.learning import simulate
from rl_design_space.learning.replay import Replay, Replayer
from rl_design_space.report.inside.animation import FRAMES, Frames, trials_shown
from rl_design_space.report.inside.picture import Picture
from rl_design_space.report.style import save
from rl_design_space.report.watching import Watch, unwatched


@dataclass(frozen=True, eq=False)
class Watched:
    """A period and one of its trials.

    Attributes:
        inside: the period: Q-matrices, visits and paths.
        snapshot: what the agent knows after the trial, and its way through it.
        name: of the design point, for titles; may be empty.
        which: which period it is, such as "worst of 500 periods"; may be empty.
    """

    inside: Replay
    snapshot: Snapshot
    name: str = ""
    which: str = ""

    @property
    def period(self) -> int:
        """Number of the period."""
        return self.inside.period

    @property
    def trial(self) -> int:
        """Number of the trial."""
        return self.snapshot.trial

    @property
    def title(self) -> str:
        """Design point and period in words."""
        which = f" ({self.which})" if self.which else ""
        total = f"{int(self.inside.steps.sum()):,} steps in {len(self.inside.steps)} trials"
        return f"{self.name + ', ' if self.name else ''}period {self.period}{which}: {total}"

    @cached_property
    def figure(self) -> Figure:
        """Values and greedy actions, visits and path, for each success counter."""
        return Picture(self.inside, self.snapshot, self.title).figure

    def save(self, stem: str | Path) -> list[Path]:
        """Write the figure as PNG and SVG; return their paths.

        Args:
            stem: path of the files without their suffix.
        """
        return save(self.figure, Path(stem))

    def frames(self, frames: int = FRAMES, watch: Watch = unwatched) -> Frames:
        """Return pictures of the period after many of its trials, to be written as GIF or as page.

        Args:
            frames: their number, at most.
            watch: shows how far the drawing is.
        """
        return Frames(self.inside, trials_shown(len(self.inside.steps), frames, [self.trial]), self.title, watch)


def watch(
    point: DesignPoint,
    period: int | str = "worst",
    trial: int | str = "last",
    *,
    total_steps: FloatArray | None = None,
    name: str = "",
) -> Watched:
    """Learn a period again, and look at one of its trials.

    Args:
        point: the design point.
        period: number of a period; or worst, median or best, by the steps of all its trials.
        trial: number of a trial; or first, last, worst, median or best, by its steps.
        total_steps: (periods,) steps of every period, if they are known; otherwise the point is learned to find them.
        name: of the point, for titles.

    Raises:
        ConfigError: there is no such period or trial, or the point cannot be learned.
    """
    if not isinstance(point, DesignPoint):
        raise ConfigError.at("point", point, "should be a DesignPoint")
    if isinstance(period, str):
        if (steps := total_steps) is None:
            learned = simulate(point)
            point, steps = learned.point, learned.total_steps
        which = f"{period} of {len(steps):,} periods"
    else:
        # The numbers of steps do not matter.
        steps, which = np.zeros(point.task.periods), ""
    inside = Replayer(point)(chosen_period(period, steps))
    return Watched(inside, snapshot(inside, chosen_trial(trial, inside.steps)), name, which)
