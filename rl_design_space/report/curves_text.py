"""A figure of learning curves as Markdown."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rl_design_space.analysis.learning_curves import curve_summary
from rl_design_space.learning.measures import NEAR
from rl_design_space.report.markdown import made_by, missing_points

if TYPE_CHECKING:
    from rl_design_space.plan.study import Study
    from rl_design_space.report.curves import CurvesFigure, Line
    from rl_design_space.report.study_runs import Runs


def curves_text(study: Study, figure: CurvesFigure, lines: list[Line], runs: Runs) -> str:
    """The figure with the commands behind it, and its lines in numbers."""
    text = [
        f"# {figure.title}",
        "",
        f"![{figure.shows}]({study.name}.png)",
        "",
        made_by(study),
        "",
        "| panel | line | total steps | 95 % interval | trials to final level | final steps / optimum | failed |",
        "|---|---|---|---|---|---|---|",
        *map(_row, lines),
        "",
    ]
    text += [
        *missing_points(study, len(runs.missing)),
        "Total steps: primitive moves of all trials of a period, mean over periods with its 95 % BCa interval. Trials "
        f"to final level: until the mean curve of steps / optimum stays within {NEAR} times its mean over the last 10 "
        "trials. Failed trials count with the moves until the step cap.",
        "",
    ]
    return "\n".join(text)


def _row(line: Line) -> str:
    if line.recorded is None:
        return f"| {line.panel} | {line.name} | missing: `{line.planned.command}` | | | | |"
    found = curve_summary(line.recorded)
    values = [
        f"{found['total_steps']:,.0f}",
        f"{found['total_low']:,.0f} – {found['total_high']:,.0f}",
        f"{found['trials_to_final']:.0f}",
        f"{found['final_over_optimum']:.3f} ({found['final_low']:.3f} – {found['final_high']:.3f})",
        f"{found['failed']:.2%} ({found['failed_low']:.2%} – {found['failed_high']:.2%})",
    ]
    return f"| {line.panel} | {line.name} | {' | '.join(values)} |"
