"""What runs on a worker of a cluster: points in, learning curves out."""

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


def prepared(planned: PlannedPoint) -> bytes:
    """A point as workers get it, with its identity.

    Raises:
        Exception: a component cannot leave its process.
    """
    return pickle.dumps((planned.fingerprint, planned.point))


def learn_chunk(points: Sequence[bytes], kernel: int, folders: Sequence[str] = ()) -> list[LearningCurves | Failure]:
    """Learn points one after the other, each whatever becomes of the others.

    Args:
        points: prepared one by one, so that one that cannot be read here leaves the others alone.
        kernel: the version of the learning algorithm that is expected.
        folders: where modules of the user's own are looked for.

    Raises:
        RuntimeError: the algorithm is another one here, so that results would not be those that are asked for.
    """
    if kernel != KERNEL_VERSION:
        raise RuntimeError(
            f"the worker's rl-design-space learns by version {KERNEL_VERSION} of the algorithm, not by {kernel}"
        )
    make_importable(folders)
    return [_learn(point) for point in points]


def _learn(prepared_point: bytes) -> LearningCurves | Failure:
    from rl_design_space.learning.simulation import simulate

    try:
        expected, point = pickle.loads(prepared_point)
        if fingerprint(point) != expected:
            raise RuntimeError("the worker has another version of an own component in memory; restart the workers")
        return simulate(point, threads=1)
    except Exception as error:
        place = extract_tb(error.__traceback__)[-1]
        return Failure(type(error).__name__, f"{error} ({place.filename}:{place.lineno})")
