"""Other definitions of the columns of a graded table: frame and text."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence

import numpy as np
import pandas as pd

from rl_design_space.analysis.at_best import Judged
from rl_design_space.analysis.orders import Order, between, order
from rl_design_space.analysis.statistics import Estimate
from rl_design_space.report.grading import GRADES, Grading
from rl_design_space.report.markdown import table
from rl_design_space.report.style import interval, number

#: Name of the definitions by which the table itself is graded.
REGISTERED = "registered"
#: Estimates by row and quantity, under one setting.
Found = Mapping[str, Mapping[str, Estimate | Judged]]
COLUMNS = [
    "column", "definition", "under", "row", "number", "low", "high", "grade", "paper", "order", "measured"
]  # fmt: skip
_MISSING = "missing"
#: A gap between two grades in words.
_GAP = "{}/{}: {} – {}"


def defined(
    gradings: Mapping[str, Mapping[str, Grading]],
    settings: Mapping[str, Found],
    rows: Sequence[str],
    paper: Mapping[str, Mapping[str, str]],
) -> pd.DataFrame:
    """Return the grades by other definitions, one row for each column, definition, setting and row of the table.

    Args:
        gradings: by column and name of the definition.
        settings: what was measured, by what it was measured under.
        rows: of the table.
        paper: published grades by row and column.

    Returns:
        `COLUMNS`; `order` says whether any limits would give the published grades of the column, see `analysis.orders`.
    """
    cells = []
    for column, by_name in gradings.items():
        published = [paper.get(row, {}).get(column, "") for row in rows]
        for name, grading in by_name.items():
            for under, found in settings.items():
                estimates = [found.get(row, {}).get(grading.of) for row in rows]
                if name == REGISTERED and not any(estimates):
                    continue
                verdict = column_order(published, estimates, grading)
                least = min((each.value for each in estimates if each), default=np.nan)
                for row, grade, each in zip(rows, published, estimates, strict=True):
                    ours = grading.grade(each.value, least) if each else ""
                    numbers = each or Estimate(np.nan, np.nan, np.nan)
                    cells.append((column, name, under, row, *numbers[:3], ours, grade, verdict, estimate_text(each)))
    return pd.DataFrame(cells, columns=COLUMNS)


def in_order(frame: pd.DataFrame) -> pd.DataFrame:
    """Return the rows of `defined` and `registered` column by column, those of the table itself once."""
    settings = frame[frame["under"] != ""]
    again = set(settings.loc[settings["definition"] == REGISTERED, "column"])
    once = frame[(frame["under"] != "") | ~frame["column"].isin(again)]
    order_of = {column: place for place, column in enumerate(dict.fromkeys(frame["column"]))}
    return once.sort_values("column", key=lambda column: column.map(order_of), kind="stable")


def column_order(
    published: Sequence[str], estimates: Sequence[Estimate | Judged | None], grading: Grading
) -> Order | str:
    """Return whether any limits would give the published grades of a column; empty if that has no meaning.

    Args:
        published: grade of each row.
        estimates: number of each row; None if it is missing.
        grading: says which numbers get the higher grades.
    """
    known = [each for each in estimates if each is not None]
    if len(known) < len(estimates) or len(known) < 2 or not set(published) <= set(GRADES):
        return ""
    return order(_ranks(published), known, larger=grading.larger)


def estimate_text(each: Estimate | Judged | None) -> str:
    """Return a number with its interval; "never" is at least the number that stands for it."""
    if each is None:
        return _MISSING
    text = f"≥ {number(each.value)}" if isinstance(each, Judged) and each.never else number(each.value)
    if each.low == each.high or (math.isinf(each.high) and each.low == each.value):
        return text
    ends = f"{number(each.low)} – ∞" if math.isinf(each.high) else interval(each.low, each.high)
    return f"{text} ({ends})" if ends else text


def definitions_text(
    frame: pd.DataFrame,
    gradings: Mapping[str, Mapping[str, Grading]],
    labels: Mapping[str, str],
    source: str,
) -> list[str]:
    """Return the paragraphs on the other definitions: their grades, and what they are.

    Args:
        frame: see `defined`.
        gradings: by column and name of the definition.
        labels: how names of rows and columns read.
        source: what the published grades are called.
    """
    limits = (
        f"limits that give the grades of the {source}" if source == "paper" else f"limits that give {source} grades"
    )
    lines = []
    for key, cells in in_order(frame).groupby(["column", "definition", "under"], sort=False):
        column, name, under = map(str, key)
        by_row = {
            labels.get(cell["row"], cell["row"]): f"{cell['grade']} {cell['measured']}".strip()
            for cell in cells.to_dict("records")
        }
        told = _limits(cells, gradings.get(column, {}).get(name))
        lines.append({"": labels.get(column, column), "definition": name, "under": under, **by_row, limits: told})
    rules = [
        f"- **{labels.get(column, column)}, {name}**: {grading.means}. {grading.rule()}."
        for column, by_name in gradings.items()
        for name, grading in by_name.items()
        if name != REGISTERED
    ]
    how = (
        f"{_counted(frame, labels)} "
        "Some limits give the grades where, of every two rows with different grades, the one with the higher grade "
        "lies beyond the other; rows with equal grades may lie anywhere between two limits. None do where two rows lie "
        "the other way round, and it cannot be told where the intervals of two such rows overlap."
    )
    return ["## By other definitions", table(pd.DataFrame(lines)), how, "\n".join(rules)]


def _counted(frame: pd.DataFrame, labels: Mapping[str, str]) -> str:
    """Return how often limits give the published grades of each column, as a sentence each."""
    verdicts = in_order(frame).drop_duplicates(["column", "definition", "under"])
    told = []
    for column, orders in verdicts[verdicts["order"] != ""].groupby("column", sort=False)["order"]:
        some, none = ((orders == verdict).sum() for verdict in ("some limits", "no limits"))
        without = f" ({none} with none)" if none else ""
        told.append(f"{labels.get(str(column), str(column))} {some} of {len(orders)}{without}")
    return f"Lines for which some limits give the grades: {', '.join(told)}." if told else ""


def _limits(cells: pd.DataFrame, grading: Grading | None) -> str:
    """Return the verdict on the order, with the gaps between grades where some limits give it."""
    verdict: str = cells["order"].iloc[0]
    if verdict != "some limits" or grading is None:
        return {"no limits": "none", "some limits": "some"}.get(verdict, verdict)
    published = sorted(set(cells["paper"]), key=GRADES.index)
    gaps = between(_ranks(cells["paper"]), list(cells["number"]), larger=grading.larger)
    told = [
        _GAP.format(higher, lower, number(low), number(high))
        for higher, lower, (low, high) in zip(published[:-1], published[1:], gaps, strict=True)
    ]
    return f"some ({', '.join(told)})" if told else "any"


def _ranks(grades: Iterable[str]) -> list[int]:
    return [len(GRADES) - GRADES.index(grade) for grade in grades]


def registered(cells: pd.DataFrame, gradings: Mapping[str, Grading]) -> pd.DataFrame:
    """Return the cells of the table itself as `defined` returns those of other definitions.

    Args:
        cells: of the table, with `low` and `high`.
        gradings: by column.
    """
    parts: list[pd.DataFrame] = []
    for column, grading in gradings.items():
        of_column = cells[cells["column"] == column]
        estimates = [
            None if math.isnan(cell["number"]) else Estimate(cell["number"], cell["low"], cell["high"])
            for cell in of_column.to_dict("records")
        ]
        verdict = column_order(list(of_column["paper"]), estimates, grading)
        texts = list(map(estimate_text, estimates))
        parts.append(of_column.assign(definition=REGISTERED, under="", order=verdict, measured=texts))
    return pd.concat(parts)[COLUMNS] if parts else pd.DataFrame(columns=COLUMNS)
