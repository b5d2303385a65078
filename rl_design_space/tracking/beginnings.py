"""Recorded runs of fewer periods of a point, which a run of more periods continues."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping
from typing import TYPE_CHECKING

from rl_design_space.plan.fingerprint import shorter_fingerprints
from rl_design_space.tracking.tracker import Beginning, StoredRun

if TYPE_CHECKING:
    from rl_design_space.plan.plan import PlannedPoint


def beginnings(
    points: Iterable[PlannedPoint],
    counts: Collection[int],
    find: Callable[[Collection[str]], Mapping[str, StoredRun]],
) -> dict[str, Beginning]:
    """Return the longest recorded run of fewer periods of each point, by the fingerprint of the point.

    The fingerprint of a point with fewer periods follows from the point and their number, so runs of earlier versions
    are found as well.

    Args:
        points: the points.
        counts: numbers of periods that recorded runs have.
        find: returns the runs of those of these fingerprints that are recorded.
    """
    shorter = {planned.fingerprint: shorter_fingerprints(planned.point, counts) for planned in points}
    wanted = {fingerprint for candidates in shorter.values() for fingerprint in candidates}
    stored = find(wanted) if wanted else {}
    found = {}
    for fingerprint, candidates in shorter.items():
        recorded = [each for each in candidates if each in stored]
        if recorded:
            longest = max(recorded, key=candidates.__getitem__)
            found[fingerprint] = Beginning(longest, candidates[longest], stored[longest])
    return found
