"""What runs hold, derived from their records."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from io import BytesIO
from math import isfinite
from typing import Any
from urllib.parse import urlencode

import yaml

from rl_design_space._markdown import code
from rl_design_space.learning.measures import CURVES
from rl_design_space.learning.result import Kept, LearningCurves
from rl_design_space.learning.stage_record import STAGE_CURVE
from rl_design_space.tracking import values
from rl_design_space.tracking.curve_picture import curve_picture, number
from rl_design_space.tracking.record import result_of
from rl_design_space.tracking.spool import CorruptedRecordError, Record
from rl_design_space.tracking.store_errors import first_line

#: In C where PyYAML has it.
_DUMPER: Any = getattr(yaml, "CSafeDumper", yaml.SafeDumper)
#: File names of a run's artifacts.
PERIODS_FILE, CONFIG_FILE, CURVE_FILE = "periods.npz", "config.yaml", "curve.svg"
#: Stands for the id of the run in the note of a sweep, which is written before the run is.
THIS_RUN = "THIS-RUN"


@dataclass(frozen=True)
class RunContent:
    """Metrics and files of a run.

    Attributes:
        metrics: (name, value, step) of each, all values finite.
        artifacts: contents of files by name.
        note: its description in Markdown.
    """

    metrics: list[tuple[str, float, int]]
    artifacts: dict[str, bytes]
    note: str


def content_of(record: Record, run_id: str) -> RunContent:
    """Return what a point's run holds beside its params and tags.

    Args:
        record: of the point.
        run_id: of the run.

    Raises:
        CorruptedRecordError: the result in the record cannot be read.
    """
    content = record.content
    try:
        learned = result_of(record)
        values_of_curves = metrics(learned, content["scalars"], content["curves"], content["every"])
        periods, trials = learned.steps.shape
        optimum = None if learned.stages else float(learned.optimum.mean())
        picture = curve_picture(learned.curves["steps/mean"].tolist(), optimum)
    except Exception as error:  # of NumPy, zlib or the archive
        reason = f"record is corrupted (its result cannot be read: {first_line(error)})"
        raise CorruptedRecordError(record.name, reason) from error
    artifacts = {
        CONFIG_FILE: config_file(content["command"], content["config"]),
        PERIODS_FILE: periods_file(learned, content["keep"]),
        CURVE_FILE: picture.encode(),
    }
    return RunContent(values_of_curves, artifacts, _note(content, periods, trials, run_id))


def shown(file: str, what: str, run_id: str = THIS_RUN) -> str:
    """Return a picture in a note; MLflow's UI shows no other addresses than those of its server.

    Args:
        file: name of the artifact.
        what: it shows.
        run_id: of the run.
    """
    return f"![{what}](get-artifact?{urlencode({'path': file, 'run_uuid': run_id})})"


def sweep_note(record: Record, run_id: str) -> str:
    """Return the note of the summary run of a sweep that has ended."""
    note: str = record.content["note"]
    return note.replace(f"={THIS_RUN}", f"={run_id}")


def _note(content: Mapping[str, Any], periods: int, trials: int, run_id: str) -> str:
    """Return the description of the run of a point: its learning curve, the main numbers, and its command."""
    scalars = content["scalars"]
    steps, error = (scalars.get(name) for name in ("total_steps", "total_steps_sem"))
    width = f" ± {number(1.96 * error)}" if error else ""
    parts = [f"{number(steps)}{width} steps in {trials:,} trials, mean of {periods:,} periods"] if steps else []
    if final := scalars.get("final_steps_over_optimum"):
        parts.append(f"the last trials take {number(final)} times the optimum")
    if failed := scalars.get("failed_trials"):
        parts.append(f"{failed:.2g} of the trials failed")
    picture = shown(CURVE_FILE, "learning curve", run_id)
    return f"{picture}\n\n{'; '.join(parts)}\n\n{code(values.tag(content['command']))}"


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
    numbers = [(name, values.metric(value)) for name, value in scalars.items()]
    found = [(name, number, 0) for name, number in numbers if number is not None]
    of_stages = [STAGE_CURVE] if STAGE_CURVE in all_curves else []
    for name in dict.fromkeys((*CURVES, *on_demand, *of_stages)):
        curve = all_curves[name].tolist()
        trials = sorted({*range(0, len(curve), every), len(curve) - 1})
        found += [(name, curve[trial], trial) for trial in trials if isfinite(curve[trial])]
    return found


def config_file(command: str, config: Mapping[str, Any]) -> bytes:
    """Return the resolved config as YAML, below a comment with the command that runs the point."""
    text: str = yaml.dump(config, Dumper=_DUMPER, sort_keys=False, allow_unicode=True)
    return f"# {command}\n{text}".encode()


def periods_file(learned: LearningCurves, keep: Kept = "periods") -> bytes:
    """Return the artifact of a result, see `LearningCurves.save`."""
    buffer = BytesIO()
    learned.save(buffer, keep=keep)
    return buffer.getvalue()
