"""Recorded runs of a point with another number of periods, whose periods are not learned again."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping
from typing import TYPE_CHECKING

from rl_design_space.plan.fingerprint import fingerprints_by_periods
from rl_design_space.tracking.tracker import Beginning, StoredRun

if TYPE_CHECKING:
    from rl_design_space.plan.plan import PlannedPoint


def beginnings(
    points: Iterable[PlannedPoint],
    counts: Collection[int],
    find: Callable[[Collection[str]], Mapping[str, StoredRun]],
) -> dict[str, Beginning]:
    """Return a recorded run of each point with another number of periods, by the fingerprint of the point.

    It is the longest; if that has more periods than the point asks for, nothing is left to learn.

    The fingerprint of a point with another number of periods follows from the point and the number, so runs of earlier
    versions are found as well.

    Args:
        points: the points.
        counts: numbers of periods that recorded runs have.
        find: returns the runs of those of these fingerprints that are recorded.
    """
    candidates = {planned.fingerprint: fingerprints_by_periods(planned.point, counts) for planned in points}
    wanted = {fingerprint for each in candidates.values() for fingerprint in each}
    stored = find(wanted) if wanted else {}
    found = {}
    for fingerprint, periods in candidates.items():
        recorded = [each for each in periods if each in stored and each != fingerprint]
        if recorded:
            longest = max(recorded, key=periods.__getitem__)
            found[fingerprint] = Beginning(longest, periods[longest], stored[longest])
    return found
