"""Tables and lines for the terminal."""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterable, Mapping, Sequence
from errno import EPIPE
from typing import Any

from hydra.core.override_parser.types import Quote, QuotedString
from rich.box import SIMPLE_HEAD
from rich.console import Console, ConsoleOptions, RenderableType
from rich.markup import escape
from rich.segment import Segment
from rich.table import Table
from rich.text import Text

from rl_design_space._visible import visible
from rl_design_space.plan.describe import present_fields
from rl_design_space.plan.plan import Plan, PlannedPoint
from rl_design_space.run.outcome import Outcome
from rl_design_space.tracking.tracker import DeliveryStatus, StoredRun


class Terminal(Console):
    """A console that shows control characters instead of sending them to the terminal; only Rich sends its own.

    A closed output is left to the command, which ends then; Rich would exit with status 1.
    """

    def render_str(self, text: str, **others: Any) -> Text:
        """Return text with its markup; what is measured is what is shown."""
        return super().render_str(visible(text), **others)

    def render(self, renderable: RenderableType, options: ConsoleOptions | None = None) -> Iterable[Segment]:
        for segment in super().render(renderable, options):
            yield segment if segment.control else Segment(visible(segment.text), segment.style)

    def on_broken_pipe(self) -> None:
        self.quiet = True
        raise BrokenPipeError(EPIPE, "nobody reads the output")


console = Terminal(highlight=False)
#: Folder of the pending records unless the command line says otherwise; what needs no quotes in an override.
_SPOOLS, _PLAIN = "outputs/spool", re.compile(r"[\w./~-]*")
#: Half the width of a 95 % interval, in standard errors.
_NORMAL_95 = 1.96
#: The longest name of a result: tables one below the other are aligned.
_LONGEST_NAME = "… in steps of a 10×10 grid"
#: Scalars of a stage that are shown of a point, and how.
_OF_STAGE = ("total_steps", "failed_trials", "final_steps_over_optimum", "carried")
_OF_STAGE_TEXT = (
    "{total_steps:,.1f} steps, {failed_trials:.2%} of trials failed, final steps over optimum "
    "{final_steps_over_optimum:.3f}, {carried:.0%} of rows carried"
)
#: Maximum number of values that a plan lists for each axis.
_SHOWN_VALUES = 12
_MINUTE, _HOUR = 60, 3600
#: Durations below this many seconds are shown with one decimal.
_TENTHS = 10


def point_table(planned: PlannedPoint, scalars: Mapping[str, float]) -> Table:
    """Return the choices of a point and its results."""
    table = _two_columns()
    for group, option in planned.options.items():
        if group not in present_fields(planned.point):
            continue
        table.add_row(group, _choice(planned, group, option))
    table.add_row("task", _choice(planned, "task", ""))
    table.add_row("seed", str(planned.point.seed))
    table.add_row("fingerprint", planned.fingerprint, end_section=True)

    total = f"{scalars['total_steps']:,.1f}"
    if "total_steps_sem" in scalars:
        total += f" ± {_NORMAL_95 * scalars['total_steps_sem']:,.1f} (95 %)"
    table.add_row("total steps a period", total)
    if "total_steps_scaled" in scalars:
        table.add_row(_LONGEST_NAME, f"{scalars['total_steps_scaled']:,.1f}")
    table.add_row("failed", f"{scalars['failed_trials']:.2%} of trials, in {scalars['failed_periods']:.1%} of periods")
    table.add_row("final steps over optimum", f"{scalars['final_steps_over_optimum']:.3f}")
    number = 1
    while f"stage{number}/total_steps" in scalars:
        of_stage = {name: scalars[f"stage{number}/{name}"] for name in _OF_STAGE}
        table.add_row(f"stage {number}", _OF_STAGE_TEXT.format(**of_stage))
        number += 1
    table.add_row("rate", f"{scalars['env_steps_per_second'] / 1e6:.1f} million steps/s")
    return table


def run_table(stored: StoredRun, location: str, is_new: bool) -> Table:
    """Return where a point is recorded, to be shown below its results.

    Args:
        stored: its run.
        location: name of the tracking store.
        is_new: whether the point was learned by this command.
    """
    table = _two_columns()
    run = f"{stored.run_id} in {location}" if stored.run_id else location
    if stored.enough:
        reached = "" if stored.enough.is_reached else ", the precision is not reached"
        table.add_row("periods", f"{stored.enough.periods:,}{reached}")
    table.add_row("MLflow run", escape(run if is_new else f"{run}; recorded earlier"))
    return table


def _two_columns() -> Table:
    table = Table(box=SIMPLE_HEAD, show_header=False, pad_edge=False)
    table.add_column(style="bold", no_wrap=True, min_width=len(_LONGEST_NAME))
    table.add_column(overflow="fold")
    return table


def plan_table(plan: Plan) -> Table:
    """Return the axes of a plan, and how many points have each value."""
    table = Table(box=SIMPLE_HEAD, pad_edge=False)
    table.add_column("axis", style="bold", no_wrap=True)
    table.add_column("values", justify="right")
    table.add_column("points with each value", overflow="fold")
    for name, counts in plan.axes.items():
        shown = [f"{value} ({count})" for value, count in list(counts.items())[:_SHOWN_VALUES]]
        more = [f"… and {len(counts) - _SHOWN_VALUES} more"] if len(counts) > _SHOWN_VALUES else []
        table.add_row(escape(name), str(len(counts)), escape("  ".join(shown + more)))
    return table


def plan_lines(plan: Plan) -> list[str]:
    """Return lines that show how the points of a plan were counted."""
    dropped = [f"- {each.count:,} dropped by {each.constraint} of {each.study}: {each.why}" for each in plan.dropped]
    repeated = [f"- {counted(plan.duplicates, 'duplicate')} of other points"] if plan.duplicates else []
    return [counted(plan.combinations, "combination"), *dropped, *repeated, f"= {counted(plan.whole, 'point')}"]


def counted(number: int, what: str) -> str:
    """Return a number with its noun: `1 point`, `2,000 points`."""
    return f"{number:,} {what}{'' if number == 1 else 's'}"


def outcome_line(plan: Plan, outcome: Outcome, location: str) -> str:
    """Return the counts of a sweep and its time by activity."""
    counts = outcome.counts
    parts = [f"{counts['done']:,} learned now", f"{counts['already']:,} before"]
    if counts["elsewhere"]:
        parts.append(f"{counts['elsewhere']:,} by another process")
    parts.append(f"{counts['failed']:,} failed")
    if counts["left"]:
        parts.append(f"{counts['left']:,} not run")
    spent = ", ".join(f"{name} {duration(seconds)}" for name, seconds in outcome.seconds.items())
    return f"{plan.name}: {counted(len(plan), 'point')}, {', '.join(parts)}; in {location} ({spent})"


def pending_line(delivery: DeliveryStatus, location: str) -> str:
    """Return how many records are pending, why, and the command that delivers them."""
    results = counted(delivery.pending, "result")
    place = delivery.spools
    if not _PLAIN.fullmatch(place):
        place = QuotedString(place, Quote.single).with_quotes()
    where = [f"tracking.spool={place}"] if delivery.spools not in ("", _SPOOLS) else []
    return (
        f"{results} of this and earlier commands safe on disk, not yet in {location}: {delivery.reason}\n"
        f"to deliver them once it is back: {shlex.join(['rl-design-space', 'sync', *where])}"
    )


def duration(seconds: float) -> str:
    """Return a time span as text: `48 s`, `3 min 20 s`, `2 h 05 min`."""
    whole = round(seconds)
    if whole < _MINUTE:
        return f"{seconds:.1f} s" if seconds < _TENTHS else f"{whole} s"
    if whole < _HOUR:
        return f"{whole // _MINUTE} min {whole % _MINUTE:02} s"
    return f"{whole // _HOUR} h {whole % _HOUR // _MINUTE:02} min"


def failure_table(plan: Sequence[PlannedPoint], failed: Mapping[str, str]) -> Table:
    """Return the failed points, their errors, and the commands that run them again."""
    table = Table(box=SIMPLE_HEAD, title="Failures")
    for heading in ("failed point", "error", "command to run it again"):
        table.add_column(heading, overflow="fold")
    for planned in plan:
        if error := failed.get(planned.fingerprint):
            table.add_row(escape(planned.name), escape(error), escape(planned.command))
    return table


def _choice(planned: PlannedPoint, group: str, option: str) -> str:
    """Return an option and its values, e.g. `linear (start=0.9 k=0.03)`."""
    values = [
        f"{name.removeprefix(f'{group}.')}={value}"
        for name, value in planned.parameters.items()
        if name.startswith(f"{group}.")
    ]
    listed = " ".join(values)
    return escape(f"{option} ({listed})" if option and listed else option or listed)
