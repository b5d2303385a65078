"""The summary run of a sweep: a note, and tables of its plan, its best points and its failures."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterable, Mapping, Sequence
from io import StringIO
from typing import TYPE_CHECKING, Any

from rl_design_space._markdown import code, escaped
from rl_design_space.learning.measures import ONLY_SCALARS, SCALARS, measure
from rl_design_space.plan.differences import differing, grid
from rl_design_space.tracking import values
from rl_design_space.tracking.content import shown
from rl_design_space.tracking.ranking_picture import Ranked, ranking_picture
from rl_design_space.tracking.tracker import recorded_as

if TYPE_CHECKING:
    from rl_design_space.plan.plan import Plan
    from rl_design_space.tracking.tracker import SweepEnding

#: What points are ranked by unless the settings say otherwise.
_USUAL = ("total_steps",)
#: Number of best points in the note, and scalars shown of each.
_BEST = 10
_SHOWN = ("total_steps", "total_steps_sem", "failed_trials", "final_steps_over_optimum")
#: Mark of points that cannot be told from the best, and the column that says which they are.
STAR, _IN_SET = "★", "in_best_set"
#: What a row holds beside the columns of the tables: the name of the run, and what it is ranked by.
_NAME, _VALUE = "run", "ranked by"
#: Half the width of a 95 % interval, in standard errors.
_NORMAL_95 = 1.96
PLAN_FILE, BEST_FILE, FAILURES_FILE = "plan.csv", "leaderboard.csv", "failures.csv"
#: The main picture: of the best points, until a report puts its own picture in its place.
PICTURE_FILE = "picture.svg"


def opening_note(plan: Plan, command: str, origin: Mapping[str, str]) -> str:
    """Return the note of a sweep that is running."""
    return _note(plan, command, origin, "running")


def closing_note(
    plan: Plan, command: str, origin: Mapping[str, str], ending: SweepEnding, names: Sequence[str] = _USUAL
) -> str:
    """Return the note of a sweep that has ended: its verdict, failures and best points by the first of these names."""
    found, marked = ending.findings, _marked(ending, names)
    parts = [_note(plan, command, origin, f"{ending.status}: {ending.verdict}")]
    if found.lines:
        parts.append("\n".join(f"- {escaped(line)}" for line in found.lines))
    if ending.failures:
        lines = [f"- {code(again)}: {escaped(error)}" for again, error in list(ending.failures.items())[:_BEST]]
        parts.append("\n".join([f"**{len(ending.failures)} failed** (all in `{FAILURES_FILE}`):", "", *lines]))
    if best := _ranked(plan, ending, names)[:_BEST]:
        if len(best) > 1:
            parts.append(shown(PICTURE_FILE, "main picture"))
        if marked is not None:
            best = [{**row, "rank": f"{row['rank']} {STAR}" if row[_IN_SET] else row["rank"]} for row in best]
        columns = (name for name in dict.fromkeys((*names, *_SHOWN)) if any(name in row for row in best))
        heading = f"Fewest {names[0]}" if tuple(names) == _USUAL else f"Best by {escaped(names[0])}"
        table = _markdown(["rank", _NAME, *columns], best)
        parts.append(f"**{heading}** (all in `{BEST_FILE}`):\n\n{table}")
        if marked is not None:
            parts.append(f"{STAR}: cannot be told from the best at 95 %, all points together, paired by period.")
    return "\n\n".join(parts)


def opening_tables(plan: Plan) -> dict[str, bytes]:
    """Return the plan as a CSV file with a row for each point."""
    columns = sorted({name for planned in plan for name in planned.parameters})
    rows = [{"fingerprint": planned.fingerprint, **planned.parameters} for planned in plan]
    return {PLAN_FILE: _csv(["fingerprint", *columns], rows)}


def closing_tables(plan: Plan, ending: SweepEnding, names: Sequence[str] = _USUAL) -> dict[str, bytes]:
    """Return CSV files: the recorded points, the best first, and the failures if there were any."""
    tables = dict(ending.findings.tables)
    if ranked := _ranked(plan, ending, names):
        scalars = dict.fromkeys((*names, *SCALARS)) if tuple(names) != _USUAL else SCALARS
        in_set = [_IN_SET] if _marked(ending, names) is not None else []
        columns = ["rank", *_axes(plan, ending), *in_set, *scalars, "run_id", "fingerprint"]
        tables[BEST_FILE] = _csv(columns, ranked)
        if len(ranked) > 1:
            tables[PICTURE_FILE] = _picture(ranked, names[0])
    if ending.failures:
        rows = [{"command": again, "error": error} for again, error in ending.failures.items()]
        tables[FAILURES_FILE] = _csv(["command", "error"], rows)
    return tables


def _note(plan: Plan, command: str, origin: Mapping[str, str], verdict: str) -> str:
    who = f"{origin.get('mlflow.user', 'unknown user')} on {origin['rl_design_space.host']}"
    version = f"rl-design-space {origin['rl_design_space.version']}"
    if commit := origin.get("mlflow.source.git.commit"):
        version += f", commit {commit[:10]}"
    return "\n".join(
        [
            f"**{escaped(plan.name)}**: {len(plan):,} point{'' if len(plan) == 1 else 's'}{_shape(plan)}",
            "",
            f"- {verdict}",
            f"- {code(values.tag(command))}",
            f"- by {who}, {version}",
        ]
    )


def _shape(plan: Plan) -> str:
    """Return in how many values of which parameters the points differ; multiplied if all combinations are points."""
    points = [{name: str(value) for name, value in planned.parameters.items()} for planned in plan]
    if whole := grid(points):
        return f" ({' × '.join(f'{count} {name}' for name, count in whole.items())})"
    counts = {name: len({point.get(name) for point in points}) for name in differing(points)}
    return f" (not all combinations of {', '.join(f'{n} {name}' for name, n in counts.items())})" if counts else ""


def _ranked(plan: Plan, ending: SweepEnding, names: Sequence[str]) -> list[dict[str, Any]]:
    """Return a row for each point of which the first of the names is known, the best first."""
    rows, axes = [], _axes(plan, ending)
    best = _marked(ending, names) or frozenset()
    never = {name for name in names if name not in ONLY_SCALARS and measure(name).is_first_trial}
    for planned in ending.findings.plan or plan:
        run = ending.stored.get(planned.fingerprint)
        if run and names[0] in run.scalars:
            own = recorded_as(planned, run).fingerprint
            parameters = planned.parameters
            ids = {"run_id": run.run_id, "fingerprint": own, _IN_SET: planned.fingerprint in best}
            ids |= {_NAME: planned.run_name(parameters), _VALUE: run.scalars[names[0]]}
            chosen = {name: value for name, value in parameters.items() if name in axes}
            # A number that stands for "never" is a lower bound.
            trials = planned.point.task.trials
            bounds = {name: f"≥ {trials}" for name in never if run.scalars.get(name, 0) >= trials}
            rows.append((run.scalars[names[0]], {**chosen, **run.scalars, **bounds, **ids}))
    descending = names[0] not in ONLY_SCALARS and measure(names[0]).largest_is_best
    rows.sort(key=lambda row: row[0], reverse=descending)
    return [{"rank": rank, **row} for rank, (_, row) in enumerate(rows, 1)]


def _picture(ranked: Sequence[Mapping[str, Any]], name: str) -> bytes:
    error = "total_steps_sem" if name == "total_steps" else ""
    points = [Ranked(row[_NAME], row[_VALUE], _NORMAL_95 * row.get(error, 0.0), row[_IN_SET]) for row in ranked]
    return ranking_picture(points, name).encode()


def _marked(ending: SweepEnding, names: Sequence[str]) -> frozenset[str] | None:
    """Return the points that cannot be told from the best by what they are ranked by; None if that is not known."""
    found = ending.findings
    return found.best if found.best_by in ("", names[0]) else None


def _axes(plan: Plan, ending: SweepEnding) -> list[str]:
    """Return the parameters in which the points differ, as planned or in the end."""
    return list((ending.findings.plan or plan).axes)


def _markdown(columns: Sequence[str], rows: Iterable[Mapping[str, Any]]) -> str:
    lines = [columns, ["---"] * len(columns), *([_cell(row.get(name, "")) for name in columns] for row in rows)]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def _cell(value: Any) -> str:
    if isinstance(value, float) and math.isfinite(value):
        return f"{value:,.4g}" if abs(value) < 1000 else f"{value:,.0f}"
    return escaped(str(value))


def _csv(columns: Sequence[str], rows: Iterable[Mapping[str, Any]]) -> bytes:
    buffer = StringIO(newline="")
    writer = csv.DictWriter(buffer, columns, extrasaction="ignore")
    writer.writeheader()
    writer.writerows(rows)
    return buffer.getvalue().encode()
