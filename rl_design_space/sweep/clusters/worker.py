"""What runs on a worker of a cluster: points in, learning curves out."""

from __future__ import annotations

import pickle
from collections.abc import Sequence
from dataclasses import dataclass
from traceback import extract_tb

from rl_design_space.learning.curves import LearningCurves
from rl_design_space.learning.version import KERNEL_VERSION


@dataclass(frozen=True)
class Failure:
    """What went wrong with a point, in words: not every exception can leave its process.

    Attributes:
        kind: name of the exception's class.
        text: its message, and the place where it was raised.
    """

    kind: str
    text: str

    def error(self) -> Exception:
        """An exception that reads like the one that was raised."""
        kind = type(self.kind, (RuntimeError,), {})
        error: Exception = kind(self.text)
        return error


def learn_chunk(points: Sequence[bytes], kernel: int) -> list[LearningCurves | Failure]:
    """Learn points one after the other, each whatever becomes of the others.

    Args:
        points: pickled one by one, so that one that cannot be read here leaves the others alone.
        kernel: the version of the learning algorithm that is expected.

    Raises:
        RuntimeError: the algorithm is another one here, so that results would not be those that are asked for.
    """
    if kernel != KERNEL_VERSION:
        raise RuntimeError(
            f"the worker's rl-design-space learns by version {KERNEL_VERSION} of the algorithm, not by {kernel}"
        )
    return [_learn(point) for point in points]


def _learn(point: bytes) -> LearningCurves | Failure:
    from rl_design_space.learning.simulation import simulate

    try:
        return simulate(pickle.loads(point), threads=1)
    except Exception as error:
        place = extract_tb(error.__traceback__)[-1]
        return Failure(type(error).__name__, f"{error} ({place.filename}:{place.lineno})")
