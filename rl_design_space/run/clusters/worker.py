"""The task of a worker of a cluster: pickled points in, learning curves out."""

from __future__ import annotations

import pickle
from collections.abc import Sequence
from dataclasses import dataclass
from traceback import extract_tb
from typing import TYPE_CHECKING

from rl_design_space.config.user_config import make_importable
from rl_design_space.learning.result import LearningCurves
from rl_design_space.learning.version import KERNEL_VERSION
from rl_design_space.plan.fingerprint import fingerprint

if TYPE_CHECKING:
    from rl_design_space.plan.plan import PlannedPoint


@dataclass(frozen=True)
class Failure:
    """The error of a point as text, because not every exception can be pickled.

    Attributes:
        kind: class name of the exception.
        text: its message, with the file and line that raised it.
    """

    kind: str
    text: str

    def error(self) -> Exception:
        """Return an exception with the same class name and message."""
        kind = type(self.kind, (RuntimeError,), {})
        error: Exception = kind(self.text)
        return error


def pickled(planned: PlannedPoint) -> bytes:
    """Return a point, its fingerprint and the result of its first periods, pickled.

    Raises:
        Exception: a component cannot be pickled.
    """
    return pickle.dumps((planned.fingerprint, planned.point, planned.begun))


def learn_chunk(points: Sequence[bytes], kernel: int, folders: Sequence[str] = ()) -> list[LearningCurves | Failure]:
    """Learn points one after the other; a failed point does not affect the others.

    Args:
        points: pickled one by one, so that one that cannot be unpickled here does not affect the others.
        kernel: the expected version of the learning algorithm.
        folders: folders that are searched for user modules.

    Raises:
        RuntimeError: this worker has another version of the learning algorithm, so its results would differ.
    """
    if kernel != KERNEL_VERSION:
        raise RuntimeError(
            f"the worker's rl-design-space has version {KERNEL_VERSION} of the learning algorithm, not {kernel}; "
            "install the same release on all machines"
        )
    make_importable(folders)
    return [_learn(point) for point in points]


def _learn(point_bytes: bytes) -> LearningCurves | Failure:
    from rl_design_space.learning.simulation import simulate

    try:
        expected, point, begun = pickle.loads(point_bytes)
        if fingerprint(point) != expected:
            raise RuntimeError("the worker has loaded another version of a user component; restart the workers")
        return simulate(point, threads=1, begun=begun)
    except Exception as error:
        place = extract_tb(error.__traceback__)[-1]
        return Failure(type(error).__name__, f"{error} ({place.filename}:{place.lineno})")
