"""The implementations that race. Each module of this folder is one of them and has the members of `Peer`."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import Protocol, cast

import numpy as np
from numpy.typing import NDArray

from benchmarks.job import Job

#: Learns periods from their layouts, (periods, 1 + goals) int32 start and goals, and a seed for the behaviour;
#: returns (periods,) primitive moves of all trials.
Learn = Callable[[NDArray[np.int32], int], NDArray[np.int64]]

OURS = "ours"
#: In the order of the table.
PEERS = (
    OURS,
    "textbook_c",
    "numba_plain",
    "jax_map",
    "jax_batch",
    "numpy_batch",
    "gymnasium_loop",
    "open_spiel_agent",
    "mushroom_rl_agent",
)


class Missing(Exception):  # noqa: N818 (nothing went wrong)
    """A peer that cannot run here; the message says why."""


class Peer(Protocol):
    """What a module has to offer to race."""

    #: Name in the table.
    TITLE: str
    #: Periods of one call: the whole 500, or as many as a slow peer learns in about two seconds.
    PERIODS: int

    def version(self) -> str:
        """The tool and its version."""
        ...

    def prepare(self, job: Job) -> Learn:
        """All that is done once for a job, before any layout is known."""
        ...


def load(name: str) -> Peer:
    """The peer of this name: a module of this folder, or of anywhere if the name has a dot.

    Raises:
        Missing: something that the peer needs is not installed.
    """
    try:
        return cast(Peer, import_module(name if "." in name else f"{__name__}.{name}"))
    except ImportError as error:
        if (error.name or "").startswith("benchmarks"):
            raise
        raise Missing(f"cannot import {error.name}: {error.msg}") from error
