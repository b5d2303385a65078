"""What the run of a design point holds, derived from its record."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from io import BytesIO
from typing import Any

import yaml

from rl_design_space.learning.measures import CURVES
from rl_design_space.learning.result import Kept, LearningCurves
from rl_design_space.learning.stage_record import STAGE_CURVE
from rl_design_space.tracking import values
from rl_design_space.tracking.record import result_of
from rl_design_space.tracking.spool import CorruptedRecordError, Record
from rl_design_space.tracking.store_errors import first_line

#: In C where PyYAML has it.
_DUMPER: Any = getattr(yaml, "CSafeDumper", yaml.SafeDumper)
#: File names of a run's artifacts.
PERIODS_FILE, CONFIG_FILE = "periods.npz", "config.yaml"


@dataclass(frozen=True)
class RunContent:
    """Metrics and files of a run.

    Attributes:
        metrics: (name, value, step) of each, all values finite.
        artifacts: contents of files by name.
    """

    metrics: list[tuple[str, float, int]]
    artifacts: dict[str, bytes]


def content_of(record: Record) -> RunContent:
    """Return what a point's run holds beside its params and tags.

    Raises:
        CorruptedRecordError: the result in the record cannot be read.
    """
    content = record.content
    try:
        learned = result_of(record)
        values_of_curves = metrics(learned, content["scalars"], content["curves"], content["every"])
    except Exception as error:  # of NumPy, zlib or the archive
        reason = f"record is corrupted (its result cannot be read: {first_line(error)})"
        raise CorruptedRecordError(record.name, reason) from error
    artifacts = {
        CONFIG_FILE: config_file(content["command"], content["config"]),
        PERIODS_FILE: periods_file(learned, content["keep"]),
    }
    return RunContent(values_of_curves, artifacts)


def metrics(
    learned: LearningCurves, scalars: Mapping[str, float], on_demand: Iterable[str], every: int = 1
) -> list[tuple[str, float, int]]:
    """Return the finite values of scalars, at step 0, and of learning curves, at step = trial.

    Args:
        learned: the result.
        scalars: values by name.
        on_demand: names of curves in addition to `measures.CURVES`.
        every: number of trials from one value of a curve to the next; the last trial is always included.

    Returns:
        (name, value, step) of each.
    """
    all_curves = learned.curves
    points = [(name, value, 0) for name, value in scalars.items()]
    of_stages = [STAGE_CURVE] if STAGE_CURVE in all_curves else []
    for name in dict.fromkeys((*CURVES, *on_demand, *of_stages)):
        curve = all_curves[name].tolist()
        trials = sorted({*range(0, len(curve), every), len(curve) - 1})
        points += [(name, curve[trial], trial) for trial in trials]
    numbers = [(name, values.metric(value), step) for name, value, step in points]
    return [(name, number, step) for name, number, step in numbers if number is not None]


def config_file(command: str, config: Mapping[str, Any]) -> bytes:
    """Return the resolved config as YAML, below a comment with the command that runs the point."""
    text: str = yaml.dump(config, Dumper=_DUMPER, sort_keys=False, allow_unicode=True)
    return f"# {command}\n{text}".encode()


def periods_file(learned: LearningCurves, keep: Kept = "periods") -> bytes:
    """Return the artifact of a result, see `LearningCurves.save`."""
    buffer = BytesIO()
    learned.save(buffer, keep=keep)
    return buffer.getvalue()
