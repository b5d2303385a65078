"""Comparison of measured values with published ones."""

from __future__ import annotations

from collections.abc import Sequence

import pandas as pd

from rl_design_space.analysis.statistics import mean_estimate, share_estimate, top_percent_weight

#: Share of periods with a failed trial, and its interval.
_FAILED = ("failed_periods", "failed_low", "failed_high")


def compare_with_published(periods: pd.DataFrame, published: pd.DataFrame) -> pd.DataFrame:
    """Return a row for each published cell, with the measured values.

    Args:
        periods: a row for each period: the keys of its cell, `value`, and `failed`, whether a trial missed the goal.
        published: a row for each cell: its keys and `paper`, the published value.

    Returns:
        The keys, `paper`, `measured` (mean over periods), `ci_low`, `ci_high` (95 %), `ratio` (measured / paper),
        `failed_periods` (share) with `failed_low`, `failed_high` (95 %, Wilson), and `top_percent` (see
        `statistics.top_percent_weight`). Values of a cell that was not measured are NaN.
    """
    keys = [column for column in published.columns if column != "paper"]
    rows = [_measure(cell, keys, group) for cell, group in periods.groupby(keys, sort=False)]
    columns = [*keys, "measured", "ci_low", "ci_high", *_FAILED, "top_percent"]
    measured = pd.DataFrame(rows, columns=columns).astype(dict.fromkeys(columns[len(keys) :], float))
    if measured.empty:
        measured = measured.astype(published.dtypes[keys].to_dict())
    table = published.merge(measured, on=keys, how="left", validate="one_to_one")
    table["ratio"] = table["measured"] / table["paper"]
    return table[[*keys, "paper", "measured", "ci_low", "ci_high", "ratio", *_FAILED, "top_percent"]]


def _measure(cell: Sequence[object], keys: Sequence[str], group: pd.DataFrame) -> dict[str, object]:
    values = group["value"].to_numpy()
    estimate = mean_estimate(values)
    return {
        **dict(zip(keys, cell, strict=True)),
        "measured": estimate.value,
        "ci_low": estimate.low,
        "ci_high": estimate.high,
        **dict(zip(_FAILED, share_estimate(group["failed"].to_numpy(dtype=bool)), strict=True)),
        "top_percent": top_percent_weight(values),
    }
