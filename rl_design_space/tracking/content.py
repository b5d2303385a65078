"""What a run of a design point holds, worked out from its record, ready for any store."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from io import BytesIO
from typing import Any

import yaml

from rl_design_space.learning.measures import CURVES
from rl_design_space.learning.result import Kept, LearningCurves
from rl_design_space.tracking import values
from rl_design_space.tracking.record import result_of
from rl_design_space.tracking.spool import Record

#: File names of a run's artifacts.
PERIODS_FILE, CONFIG_FILE = "periods.npz", "config.yaml"


@dataclass(frozen=True)
class RunContent:
    """Metrics and files of a run.

    Attributes:
        metrics: as (name, value, step), all finite.
        artifacts: files by name.
    """

    metrics: list[tuple[str, float, int]]
    artifacts: dict[str, bytes]


def content_of(record: Record) -> RunContent:
    """What a point's run holds beside its params and tags.

    Raises:
        KeyError: the record is not that of a point.
    """
    told, learned = record.content, result_of(record)
    artifacts = {
        CONFIG_FILE: config_file(told["command"], told["config"]),
        PERIODS_FILE: periods_file(learned, told["keep"]),
    }
    return RunContent(metrics(learned, told["scalars"], told["curves"], told["every"]), artifacts)


def metrics(
    learned: LearningCurves, scalars: Mapping[str, float], on_demand: Iterable[str], every: int = 1
) -> list[tuple[str, float, int]]:
    """Scalars at step 0 and learning curves at step = trial; only finite values.

    Of a curve, every so many trials are taken, and the last one.
    """
    found = learned.curves
    points = [(name, value, 0) for name, value in scalars.items()]
    for name in dict.fromkeys((*CURVES, *on_demand)):
        curve = found[name].tolist()
        trials = sorted({*range(0, len(curve), every), len(curve) - 1})
        points += [(name, curve[trial], trial) for trial in trials]
    numbers = [(name, values.metric(value), step) for name, value, step in points]
    return [(name, number, step) for name, number, step in numbers if number is not None]


def config_file(command: str, config: Mapping[str, Any]) -> bytes:
    """The resolved config, every value written out, under the command that runs the point."""
    return f"# {command}\n{yaml.safe_dump(config, sort_keys=False, allow_unicode=True)}".encode()


def periods_file(learned: LearningCurves, keep: Kept = "periods") -> bytes:
    """Return the artifact of a result, see `LearningCurves.save`."""
    buffer = BytesIO()
    learned.save(buffer, keep=keep)
    return buffer.getvalue()
