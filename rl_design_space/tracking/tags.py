"""Names of the tags of runs that this package writes and searches for."""

from __future__ import annotations

from collections.abc import Iterable
from functools import lru_cache

from rl_design_space.tracking import values

#: Prefix of the tags of a run that name its studies, one tag for each.
STUDY_TAG = "study."
#: Fingerprint of a run's design point.
FINGERPRINT_TAG = "fingerprint"
#: Id of the sweep that a summary run belongs to.
SWEEP_TAG = "rl_design_space.sweep"
#: Identity of the spool that a run is written from.
SPOOL_TAG = "rl_design_space.spool"
#: The note of a run, which MLflow's UI shows.
NOTE_TAG = "mlflow.note.content"
#: Why a run is incomplete.
INCOMPLETE_TAG = "rl_design_space.incomplete"


def study_tags(studies: Iterable[str]) -> dict[str, str]:
    """Return a tag for each study.

    Raises:
        ConfigError: MLflow would refuse the name of a study.
    """
    return {values.key(f"{STUDY_TAG}{study}"): "true" for study in studies}


def studies_of(tags: Iterable[str]) -> frozenset[str]:
    """Return the studies that tags name."""
    return _studies(tuple(tags))


@lru_cache(maxsize=1024)
def _studies(tags: tuple[str, ...]) -> frozenset[str]:
    """Return the studies that tags name; thousands of runs have the same tags."""
    return frozenset(tag.removeprefix(STUDY_TAG) for tag in tags if tag.startswith(STUDY_TAG))
