"""The result of a race: the set of the best, what it took, and the tables of its summary run."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from io import StringIO
from typing import Any

import numpy as np

from rl_design_space._arrays import FloatArray
from rl_design_space.analysis.best import BestSet
from rl_design_space.plan.differences import differing
from rl_design_space.plan.plan import Plan
from rl_design_space.tracking.tracker import Findings

#: File of the summary run with a row for each design.
RACE_FILE = "race.csv"
STAR = "★"
#: Designs that are listed, and half the width of a 95 % interval in standard errors.
_LISTED, _NORMAL_95 = 10, 1.96
_PERIODS = "task.periods"
#: Key of the periods of the first look.
_FIRST = "hydra.sweeper.first"


@dataclass(frozen=True)
class RaceResult:
    """How a race ended; arrays are (designs,).

    Attributes:
        plan: the points with as many periods as they got; those that failed are left out.
        name: of the measure that decided.
        values: of the points.
        errors: their standard errors.
        steps: their steps.
        best: the set of the best.
        first: periods that all began with.
        most: periods of those that went on to the end.
        confidence: with which the set holds the best.
        largest_is_best: whether a large value is good.
        failed: number of designs that failed, at whichever look.
    """

    plan: Plan
    name: str
    values: FloatArray
    errors: FloatArray
    steps: FloatArray
    best: BestSet
    first: int
    most: int
    confidence: float
    largest_is_best: bool = False
    failed: int = 0

    @property
    def periods(self) -> FloatArray:
        """(designs,) periods that each got."""
        return np.array([planned.point.task.periods for planned in self.plan], dtype=float)

    @property
    def spent(self) -> float:
        """Steps of the race."""
        return float(self.steps.sum())

    @property
    def full(self) -> float:
        """Steps of all points with all periods, of which those that stopped go on as they began."""
        return float((self.steps / self.periods).sum() * self.most)

    @property
    def lines(self) -> list[str]:
        """What the race took, and the size of the set."""
        inside, designs = int(self.best.inside.sum()), len(self.plan)
        at_end = int((self.periods == self.most).sum())
        what = "1 design" if inside == 1 else f"{inside:,} designs"
        took = (
            f"race: {designs + self.failed:,} designs began with {self.first:,} periods, {at_end:,} went on to "
            f"{self.most:,}; {_millions(self.spent)} steps, {self.spent / self.full:.1%} of about "
            f"{_millions(self.full)} of the full sweep"
        )
        if self.first == self.most:
            took = (
                f"race: {_PERIODS}={self.most:,} is not above {_FIRST}, so none of {designs:,} designs stopped early; "
                f"{_millions(self.spent)} steps, as many as the full sweep"
            )
        failed = f"{self.failed:,} of them failed and are left out, although one may be the best"
        return [
            took,
            *([failed] if self.failed else []),
            f"{what} of {designs:,} cannot be told from the best by {self.name} at {100 * self.confidence:.4g} %",
        ]

    @property
    def listed(self) -> list[str]:
        """The designs of the set with the best values."""
        parameters = [_plain(planned.parameters) for planned in self.plan]
        names = [name for name in differing(parameters) if name != _PERIODS]
        lines = []
        inside = [number for number in self._ranked if self.best.inside[number]]
        for number in inside[:_LISTED]:
            design = parameters[number]
            values = " ".join(f"{name}={design[name]}" for name in names if name in design)
            width = f" ± {_NORMAL_95 * self.errors[number]:,.4g}"
            loss = f"loses at most {self.best.loss_at_most[number]:,.4g}"
            lines.append(f"{STAR} {_number(self.values[number])}{width}  {values}, {loss}")
        return [*lines, *([f"and {len(inside) - _LISTED:,} more"] if len(inside) > _LISTED else [])]

    @property
    def findings(self) -> Findings:
        """What the summary run records."""
        inside = np.flatnonzero(self.best.inside)
        return Findings(
            plan=self.plan,
            best=frozenset(self.plan[number].fingerprint for number in inside.tolist()),
            lines=self.lines,
            tables={RACE_FILE: self._table()},
            metrics={
                "race/steps": self.spent,
                "race/steps_of_full_sweep": self.full,
                "race/share_of_steps": self.spent / self.full,
                "race/best_set": float(len(inside)),
            },
        )

    @property
    def _ranked(self) -> Sequence[int]:
        """The designs, those of the set first, then those with most periods, and each of them the best first."""
        value = -self.values if self.largest_is_best else self.values
        ranked: list[int] = np.lexsort((value, -self.periods, ~self.best.inside)).tolist()
        return ranked

    def _table(self) -> bytes:
        """Return a row for each design as CSV."""
        names = list(self.plan.axes)
        columns = ["rank", *names, "value", "standard_error", "in_best_set", "loss_at_most", "steps", "fingerprint"]
        buffer = StringIO(newline="")
        writer = csv.DictWriter(buffer, columns)
        writer.writeheader()
        for rank, number in enumerate(self._ranked, 1):
            planned = self.plan[number]
            writer.writerow(
                {
                    "rank": rank,
                    **{name: value for name, value in planned.parameters.items() if name in names},
                    "value": self.values[number],
                    "standard_error": self.errors[number],
                    "in_best_set": bool(self.best.inside[number]),
                    "loss_at_most": self.best.loss_at_most[number],
                    "steps": int(self.steps[number]),
                    "fingerprint": planned.fingerprint,
                }
            )
        return buffer.getvalue().encode()


def _plain(parameters: Mapping[str, Any]) -> dict[str, Any]:
    """Return parameters with lists as text, which can be compared."""
    return {name: str(value) if isinstance(value, list) else value for name, value in parameters.items()}


def _millions(steps: float) -> str:
    return f"{steps / 1e6:,.3g} million" if steps < 1e9 else f"{steps / 1e6:,.0f} million"


def _number(value: float) -> str:
    return f"{value:,.0f}" if abs(value) >= 1000 else f"{value:,.4g}"
