"""What people see in the terminal."""

from __future__ import annotations

from collections.abc import Sequence

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table

from rl_design_space.sweep.plan import PlannedPoint
from rl_design_space.tracking.tracker import StoredRun

console = Console(highlight=False)
#: Half the width of a 95 % interval, in standard errors.
_NORMAL_95 = 1.96


def point_table(planned: PlannedPoint, stored: StoredRun, location: str, learned: bool) -> Table:
    """The choices of a point and what came of them."""
    table = Table(box=SIMPLE_HEAD, show_header=False, pad_edge=False)
    table.add_column(style="bold", no_wrap=True)
    table.add_column(overflow="fold")
    for group, option in planned.options.items():
        table.add_row(group, _choice(planned, group, option))
    table.add_row("task", _choice(planned, "task", ""))
    table.add_row("seed", str(planned.point.seed))
    table.add_row("fingerprint", planned.fingerprint, end_section=True)

    scalars = stored.scalars
    total = f"{scalars['total_steps']:,.1f}"
    if "total_steps_sem" in scalars:
        total += f" ± {_NORMAL_95 * scalars['total_steps_sem']:,.1f} (95 %)"
    table.add_row("total steps a period", total)
    if "total_steps_scaled" in scalars:
        table.add_row("… in steps of a 10×10 grid", f"{scalars['total_steps_scaled']:,.1f}")
    table.add_row("failed", f"{scalars['failed_trials']:.2%} of trials, in {scalars['failed_periods']:.1%} of periods")
    table.add_row("final steps over optimum", f"{scalars['final_steps_over_optimum']:.3f}")
    table.add_row("rate", f"{scalars['env_steps_per_second'] / 1e6:.1f} million steps/s", end_section=True)
    run = f"{stored.run_id} in {location}" if stored.run_id else location
    table.add_row("MLflow run", escape(run if learned else f"{run}; recorded earlier, nothing to learn"))
    return table


class SweepDisplay:
    """Progress of a sweep: one live line in a terminal, a plain line a point elsewhere."""

    def __init__(self, name: str, points: int) -> None:
        self._name = name
        self._points = points
        self._reported = 0
        columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
        self._progress = Progress(*columns, console=console, transient=True, disable=not console.is_terminal)
        self._task = self._progress.add_task(name, total=points)

    def __enter__(self) -> SweepDisplay:
        self._progress.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._progress.stop()

    def report(self, planned: PlannedPoint, result: StoredRun | Exception) -> None:
        """Show that a point has ended; failures at once."""
        self._reported += 1
        self._progress.update(self._task, advance=1, description=f"{self._name}: {planned.name}")
        if isinstance(result, Exception):
            console.print(
                escape(f"failed: {planned.command}\n  {type(result).__name__}: {result}"), style="red", soft_wrap=True
            )
        elif not console.is_terminal:
            total = f"{result.scalars['total_steps']:,.1f}"
            console.print(
                escape(f"[{self._reported}/{self._points}] {planned.name}: {total} steps a period"), soft_wrap=True
            )


def failure_table(plan: Sequence[PlannedPoint], failed: dict[str, Exception]) -> Table:
    """Every point that failed, why, and the command that runs it again."""
    table = Table(box=SIMPLE_HEAD, title="Failures")
    for heading in ("failed point", "error", "run it again"):
        table.add_column(heading, overflow="fold")
    for planned in plan:
        if error := failed.get(planned.fingerprint):
            table.add_row(planned.name, escape(f"{type(error).__name__}: {error}"), escape(planned.command))
    return table


def _choice(planned: PlannedPoint, group: str, option: str) -> str:
    """An option and its values, e.g. `linear (start=0.9 k=0.03)`."""
    values = [
        f"{name.removeprefix(f'{group}.')}={value}"
        for name, value in planned.parameters.items()
        if name.startswith(f"{group}.")
    ]
    listed = " ".join(values)
    return escape(f"{option} ({listed})" if option and listed else option or listed)
