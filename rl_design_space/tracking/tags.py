"""Names of the tags of runs that this package writes and searches for."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import lru_cache

from rl_design_space.tracking import values
from rl_design_space.tracking.tracker import Enough

#: Prefix of the tags of a run that name its studies, one tag for each.
STUDY_TAG = "study."
#: Prefix of the tags of a run that name points which ask for a precision and have this result, by their fingerprints;
#: by itself, the name of the tag that says so in words.
PRECISION_TAG = "precision"
#: Fingerprint of a run's design point.
FINGERPRINT_TAG = "fingerprint"
#: Id of the sweep that a summary run belongs to.
SWEEP_TAG = "rl_design_space.sweep"
#: Identity of the spool that a run is written from.
SPOOL_TAG = "rl_design_space.spool"
#: The note of a run, which MLflow's UI shows.
NOTE_TAG = "mlflow.note.content"
#: The learner of a run whose result was measured by a program of the user's.
EXTERNAL_TAG = "rl_design_space.external"
#: Why a run is incomplete.
INCOMPLETE_TAG = "rl_design_space.incomplete"

#: End of the value of a tag of a precision that was not reached.
_NOT_REACHED = ", not reached"


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


def precision_tags(fingerprint: str, enough: Enough, words: str) -> dict[str, str]:
    """Return the tags of the result of a point that asks for a precision.

    Args:
        fingerprint: of the point.
        enough: how many periods it needed.
        words: the same as text, which the run shows.
    """
    found = f"{enough.periods}{'' if enough.is_reached else _NOT_REACHED}"
    return {PRECISION_TAG: values.tag(words), f"{PRECISION_TAG}.{fingerprint}": found}


def enough_of(tags: Mapping[str, str], fingerprint: str) -> Enough | None:
    """Return how many periods the precision of a point needed; None if the tags do not say so."""
    return enough(tags.get(f"{PRECISION_TAG}.{fingerprint}", ""))


def enough(text: str) -> Enough | None:
    """Return what the value of a tag says, see `precision_tags`; None if it says nothing."""
    periods = text.removesuffix(_NOT_REACHED)
    return Enough(int(periods), periods == text) if periods.isdecimal() else None


def of_any_command(tags: Mapping[str, str]) -> dict[str, str]:
    """Return those tags of a point that its run gets from every command that asks for it: studies, and precisions."""
    return {name: value for name, value in tags.items() if name.startswith((STUDY_TAG, PRECISION_TAG))}


def fingerprints_of(tags: Mapping[str, str]) -> dict[str, Enough | None]:
    """Return the fingerprints of the points whose result a run holds: its own, and those that ask for a precision."""
    prefix = f"{PRECISION_TAG}."
    asked = {name.removeprefix(prefix): enough(value) for name, value in tags.items() if name.startswith(prefix)}
    return {tags.get(FINGERPRINT_TAG, ""): None, **asked}
