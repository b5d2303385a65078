"""Recorded runs as a tidy pandas frame: the choices and the scalars of each point."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from rl_design_space.config.overrides import with_absent
from rl_design_space.errors import ConfigError
from rl_design_space.learning.measures import SCALARS
from rl_design_space.learning.stage_record import is_scalar_name
from rl_design_space.tracking.tags import FINGERPRINT_TAG, studies_of

if TYPE_CHECKING:
    import pandas as pd

    from rl_design_space.tracking.found_run import FoundRun

#: Numbers as Python writes them. Anything else is text, such as 010, 1:30 and 2020-01-01, which YAML would convert.
_INTEGER, _DECIMAL = re.compile(r"-?(0|[1-9]\d*)"), re.compile(r"-?\d+\.\d*")
_EXPONENT = re.compile(r"-?\d+(\.\d+)?e[+-]?\d+")
_TRUTH = {"true": True, "false": False}
#: Number of characters that no number has; Python refuses to convert thousands of digits.
_LONGEST = 400
#: Columns of a frame of runs that are neither params nor scalars; its index is `run_id`.
ABOUT = ("run_id", "name", "fingerprint", "studies", "started", "ended", "artifacts")


def frame_of(found: Iterable[FoundRun]) -> pd.DataFrame:
    """Return a frame with a row for each run, by run id.

    Returns:
        `name`, `fingerprint`, `studies` (names, separated by spaces), `started` and `ended` (UTC), `artifacts` (URI of
        their folder); a column for every param, of numbers if all its values are; and the
        scalars, those of stages as `stage2/total_steps`.
    """
    import pandas as pd

    runs = sorted(found, key=lambda run: (run.started, run.run_id))
    index = pd.Index([run.run_id for run in runs], name="run_id")
    columns: dict[str, Any] = {
        "name": [run.name for run in runs],
        "fingerprint": [run.tags.get(FINGERPRINT_TAG) for run in runs],
        "studies": [" ".join(sorted(studies_of(run.tags))) for run in runs],
        "started": _times(run.started for run in runs),
        "ended": _times(run.ended for run in runs),
        "artifacts": [run.artifacts for run in runs],
    }
    params = with_absent([run.params for run in runs])
    for name in sorted(set().union(*params)):
        texts = [each.get(name) for each in params]
        values = {text: typed(text) for text in set(texts)}
        # One type of values in a column.
        is_text = any(isinstance(value, str) for value in values.values())
        columns[name] = texts if is_text else [values[text] for text in texts]
    metrics = [run.metrics for run in runs]
    of_stages = sorted({name for each in metrics for name in each if is_scalar_name(name)})
    for name in (*SCALARS, *of_stages):
        columns[name] = pd.array([each.get(name) for each in metrics], dtype="float64")
    return pd.DataFrame(columns, index=index)


def of_study(frame: pd.DataFrame, study: str) -> pd.DataFrame:
    """Return the runs that belong to a study.

    Raises:
        ConfigError: there are none; the message lists the studies.
    """
    belongs = frame["studies"].map(lambda names: study in names.split(" ")).astype(bool)
    if not belongs.any():
        known = {name for names in frame["studies"].unique() for name in names.split(" ") if name}
        raise ConfigError.unknown("study among these runs", study, known)
    return frame[belongs]


def filtered(found: Sequence[FoundRun], text: str) -> list[FoundRun]:
    """Return the runs that match a filter of MLflow's search: `params.world = 'torus' and metrics.total_steps < 9000`.

    Raises:
        ConfigError: the text is not a filter.
    """
    from types import SimpleNamespace

    from mlflow.exceptions import MlflowException
    from mlflow.utils.search_utils import SearchUtils

    def as_mlflow_run(run: FoundRun) -> SimpleNamespace:
        info = SimpleNamespace(
            run_id=run.run_id, run_name=run.name, start_time=run.started, end_time=run.ended, status="FINISHED",
            artifact_uri=run.artifacts,
        )  # fmt: skip
        data = SimpleNamespace(params=run.params, metrics=run.metrics, tags=run.tags)
        return SimpleNamespace(info=info, data=data, inputs=SimpleNamespace(dataset_inputs=[]), found=run)

    try:
        matching = SearchUtils.filter([as_mlflow_run(run) for run in found], text)  # type: ignore[no-untyped-call]
        return [each.found for each in matching]
    except MlflowException as error:
        first_line = str(error).splitlines()[0]
        raise ConfigError.at("filter", text, f"should be a filter of MLflow's search: {first_line}") from error


@lru_cache(maxsize=4096)
def typed(text: str | None) -> Any:
    """Return a param as it was before MLflow made text of it; lists stay text, so that runs can be grouped by them."""
    if text is None or len(text) > _LONGEST:
        return text
    if _INTEGER.fullmatch(text):
        return int(text)
    if _DECIMAL.fullmatch(text):
        return float(text)
    return float(text) if _EXPONENT.fullmatch(text) else _TRUTH.get(text.lower(), text)


def _times(milliseconds: Iterable[int]) -> pd.DatetimeIndex:
    import numpy as np
    import pandas as pd

    return pd.DatetimeIndex(np.array(list(milliseconds), "datetime64[ms]")).tz_localize("UTC")
