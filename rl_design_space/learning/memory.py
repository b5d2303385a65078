"""The memory that the results of a point need, compared with that of the machine."""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path

from rl_design_space.design import Task
from rl_design_space.errors import ConfigError

#: Bytes of the result of a trial: its steps, and whether it succeeded.
_TRIAL = 5
#: Bytes for the start and each goal of a period, and bytes of a period beside these: its optimum and generator.
_PLACE, _PERIOD = 24, 64
#: Maximum memory of a container.
_CONTAINER = Path("/sys/fs/cgroup/memory.max")
_GB = 1e9


def check_memory(task: Task, available: float | None = None) -> None:
    """Refuse a task whose results cannot fit into memory; the operating system would end the process without a word.

    Args:
        task: the task.
        available: bytes of memory; that of this machine if None.

    Raises:
        ConfigError: the results need more memory than there is.
    """
    available = available_memory() if available is None else available
    needed = task.periods * (_TRIAL * task.trials + _PLACE * (task.goals + 1) + _PERIOD)
    if needed > available:
        key = "periods" if task.periods > task.trials else "trials"
        raise ConfigError.at(
            f"task.{key}",
            getattr(task, key),
            f"{task.periods:,} periods of {task.trials:,} trials need {needed / _GB:,.0f} GB of memory, "
            f"and this machine has {available / _GB:,.0f} GB; use fewer",
        )


def available_memory() -> float:
    """Return the bytes of memory of this machine, or of the container that the process runs in."""
    try:
        memory = float(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
    except (ValueError, OSError, AttributeError):  # not known on this system
        return float("inf")
    with suppress(OSError, ValueError):  # no container, or one without a limit
        memory = min(memory, float(_CONTAINER.read_text()))
    return memory
