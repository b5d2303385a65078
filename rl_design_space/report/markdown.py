"""Reports as Markdown."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from rl_design_space.report.published_table import HEAVY_TAIL

if TYPE_CHECKING:
    import pandas as pd

    from rl_design_space.plan.study import Study
    from rl_design_space.report.published_table import PublishedTable


def made_by(study: Study) -> str:
    """Where a report comes from: the commands behind it, and how many periods a point has."""
    if not study.plan:
        return f"Made by `{study.report_command}`, which needs no runs."
    periods = " or ".join(map(str, sorted({planned.point.task.periods for planned in study.plan})))
    return f"Made by `{study.report_command}` from runs of `{study.command}`, {periods} periods a point."


def missing_points(study: Study, missing: int) -> list[str]:
    """A paragraph that says how points that are missing are made; nothing if there are none."""
    if not missing:
        return []
    return [f"**Missing: {missing} of {len(study.plan)} points**; `{study.command}` makes them.", ""]


def published_table_text(study: Study, cells: pd.DataFrame, table: PublishedTable) -> str:
    """The table with its picture, the commands behind it, and how to read it."""
    measured = cells.dropna(subset="measured")
    lines = [
        f"# {table.title}",
        "",
        f"![{table.title}: measured and published values]({study.name}.png)",
        "",
        made_by(study),
        "",
        *_rows(cells, table),
        "",
    ]
    if len(measured):
        lines += [_fit(measured, table), ""]
    missing = int((cells["planned"] & cells["measured"].isna()).sum())
    if missing:
        lines += [f"**Missing: {missing} of {len(cells)} cells**; `{study.command}` makes them.", ""]
    outside = int((~cells["planned"]).sum())
    if outside:
        lines += [f"Not asked for: {outside} of {len(cells)} cells.", ""]
    lines += [
        "Measured is the mean over periods of the primitive moves of all trials, failed trials included with the "
        "moves until the step cap; in brackets the 95 % BCa bootstrap interval over periods. The paper gives one "
        "number a cell and no spread.",
        "",
        f"Heavy tail (†): the 1 % of periods with most steps need {HEAVY_TAIL} times the mean or more. Such a mean "
        "hangs on few periods, the paper's as much as ours, so its ratio says little.",
        "",
    ]
    return "\n".join(lines)


def _rows(cells: pd.DataFrame, table: PublishedTable) -> list[str]:
    header = [*table.axes, "paper", "measured", "95 % interval", "ratio", "periods with a failed trial"]
    rows = [f"| {' | '.join(header)} |", f"|{'---|' * len(header)}"]
    for cell in cells.to_dict("records"):
        keys = [str(cell[axis]) for axis in table.axes]
        if np.isnan(cell["measured"]):
            values = [f"{cell['paper']:,.0f}", "missing" if cell["planned"] else "not asked for", "", "", ""]
        else:
            tail = " †" if cell["top_percent"] >= HEAVY_TAIL else ""
            values = [
                f"{cell['paper']:,.0f}",
                f"{cell['measured']:,.0f}",
                interval_text(cell),
                f"{cell['ratio']:.3f}",
                f"{cell['failed_periods']:.1%} ({cell['failed_low']:.1%} – {cell['failed_high']:.1%}){tail}",
            ]
        rows.append(f"| {' | '.join([*keys, *values])} |")
    return rows


def interval_text(cell: dict[Any, Any]) -> str:
    """The interval of a cell; empty if there is none, with a single period."""
    return "" if np.isnan(cell["ci_low"]) else f"{cell['ci_low']:,.0f} – {cell['ci_high']:,.0f}"


def _fit(measured: pd.DataFrame, table: PublishedTable) -> str:
    """How far measured and published lie apart, a panel at a time."""
    panel = next(iter(table.panel))
    parts = []
    for name, here in measured.groupby(panel, sort=False):
        log_ratio = np.log(here["ratio"])
        rms = np.expm1(np.sqrt((log_ratio**2).mean()))
        worst = np.expm1(log_ratio.abs().max())
        parts.append(f"{table.label(name)}: rms {rms:.1%}, largest {worst:.1%}")
    return f"Distance from the paper (log ratio): {'; '.join(parts)}."
