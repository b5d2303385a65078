"""Joint specifications: under which most claims hold at once, what that costs, and how well placebos would do."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd

from rl_design_space.analysis.multiverse.joint import best_joint, placebo
from rl_design_space.report.multiverse_claims import Role
from rl_design_space.report.multiverse_outcomes import ClaimOutcomes
from rl_design_space.report.multiverse_points import Space

#: Names of the joint specifications, from the one without choice to the one with all of it.
REGISTERED, DECIDED, LIMITS, ANY = "as registered", "the decided reading", "the registered limits", "anything tried"
_COLUMNS = [
    "within", "reading", "statistic", "threshold", "measures", "hold", "of", "departures", "claims", "gains", "loses",
    "placebo", "placebo_same", "placebo_mean", "placebos",
]  # fmt: skip


def joint_frame(found: Mapping[str, ClaimOutcomes], space: Space, roles: Mapping[str, Role]) -> pd.DataFrame:
    """Return the specification under which most claims hold at once, within more and more choices.

    Args:
        found: outcomes of the claims by name.
        space: what the specifications are made of.
        roles: what the words of the claims may be measured by.

    Returns:
        within (what might be chosen), reading, statistic, threshold, measures; hold (number of claims that hold), of
        (number of claims); departures from the registered choices; claims (that hold), gains and loses (claims that
        hold here or as registered alone); placebo (share of the placebos of which as many hold, when the same choices
        are searched for each), placebo_same (the same under this specification), placebo_mean (claims of a placebo
        that hold), placebos (their number).
    """
    claims = [each.outcomes for each in found.values() if any(row.what for row in each.rows)]
    if not claims:
        return pd.DataFrame(columns=_COLUMNS)
    statistics = max((role.statistics for role in roles.values()), key=len, default=("mean",))
    readings = space.readings[: space.every]
    shape = len(readings), len(statistics), len(space.thresholds)
    away = np.array([len(reading) for reading in readings])
    departures = np.add.outer(np.add.outer(away, np.arange(shape[1]) > 0), np.arange(shape[2]) > 0).astype(int)
    every = np.ones(shape, np.bool_)
    registered = [each.claim for each in claims if each.holds[0, 0, 0, 0]]
    rows = []
    for name, within in (
        (DECIDED, every & (away == 0)[:, np.newaxis, np.newaxis]),
        (LIMITS, every & (np.arange(shape[2]) == 0)),
        (ANY, every),
    ):
        joint = best_joint(claims, departures, within)
        odds = placebo(claims, joint, within)
        measures = {role: roles[role].measures[number] for role, number in joint.measures.items() if role}
        moved = sum(number > 0 for number in joint.measures.values())
        gains = [claim for claim in joint.claims if claim not in registered]
        loses = [claim for claim in registered if claim not in joint.claims]
        rows.append((
            name, space.reading(joint.reading), statistics[joint.statistic], space.thresholds[joint.threshold],
            "; ".join(f"{role}: {measure}" for role, measure in measures.items()), len(joint.claims), len(claims),
            int(departures[joint.reading, joint.statistic, joint.threshold]) + moved, ", ".join(joint.claims),
            ", ".join(gains), ", ".join(loses), odds.searched, odds.same, odds.mean, odds.draws,
        ))  # fmt: skip
    first = (
        REGISTERED, space.reading(0), statistics[0], space.thresholds[0], "the first of each role", len(registered),
        len(claims), 0, ", ".join(registered), "", "", np.nan, np.nan, np.nan, 0,
    )  # fmt: skip
    return pd.DataFrame([first, *rows], columns=_COLUMNS)
