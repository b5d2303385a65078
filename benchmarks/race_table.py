"""The table of a race."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from benchmarks.peers import OURS
from benchmarks.race import Entrant
from benchmarks.tables import number, spread


def frame_of(entrants: Sequence[Entrant]) -> pd.DataFrame:
    """One row a peer, all numbers as numbers. Times of a void peer are left out: they are of another job."""
    ours = next(entrant for entrant in entrants if entrant.name == OURS)
    return pd.DataFrame([_row(entrant, ours) for entrant in entrants])


def _row(entrant: Entrant, ours: Entrant) -> dict[str, object]:
    state = "VOID" if entrant.void else entrant.state
    timed = state == "ok" and entrant.calls
    ns_low, ns, ns_high = np.quantile([call.ns for call in entrant.calls], (0.25, 0.5, 0.75)) if timed else [np.nan] * 3
    ratio_low, ratio, ratio_high = np.quantile(entrant.ratios(ours), (0.25, 0.5, 0.75)) if timed else [np.nan] * 3
    agreement = entrant.agreement
    return {
        "peer": entrant.name,
        "title": entrant.title,
        "version": entrant.version,
        "state": state,
        "ns_per_step": ns,
        "ns_q25": ns_low,
        "ns_q75": ns_high,
        "ratio": ratio,
        "ratio_q25": ratio_low,
        "ratio_q75": ratio_high,
        "start_seconds": entrant.start_seconds,
        "compile_seconds": entrant.compile_seconds,
        "peak_mib": entrant.peak_mib,
        "rounds": len(entrant.calls),
        "periods": agreement.periods if agreement else 0,
        "total_steps": agreement.mean if agreement else np.nan,
        "total_steps_sem": agreement.sem if agreement else np.nan,
        "difference": agreement.difference if agreement else np.nan,
        "detectable": agreement.detectable if agreement else np.nan,
        "t": agreement.t if agreement else np.nan,
        "note": entrant.note,
    }


def text_of(frame: pd.DataFrame) -> pd.DataFrame:
    """The table that people read."""
    return pd.DataFrame([_text_row(row) for row in frame.to_dict("records")])


def calls_frame(entrants: Sequence[Entrant]) -> pd.DataFrame:
    """One row a timed call."""
    rows = [(entrant.name, *call, call.ns) for entrant in entrants for call in entrant.calls]
    return pd.DataFrame(rows, columns=["peer", "round", "seconds", "steps", "ns_per_step"])


def versions(frame: pd.DataFrame) -> dict[str, str]:
    """What each implementation is, or why it is not there."""
    return {row["title"]: row["note"] or row["version"] for row in frame.to_dict("records")}


def _text_row(row: Mapping[Any, Any]) -> dict[str, str]:
    total = "–"
    if not np.isnan(row["total_steps"]):
        total = f"{row['total_steps']:,.0f} ± {row['total_steps_sem']:,.0f}"
    return {
        "implementation": row["title"],
        "ns a step": number(row["ns_per_step"]) if row["state"] == "ok" else row["state"],
        "ratio": spread(row, "ratio", "ratio_q25", "ratio_q75"),
        "start s": number(row["start_seconds"]),
        "compile s": number(row["compile_seconds"]),
        "peak MiB": number(row["peak_mib"]),
        "steps a period": total,
        "t": "–" if row["peer"] == OURS else number(row["t"]),
    }
