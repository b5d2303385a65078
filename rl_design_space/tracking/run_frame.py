"""Tracked runs as a tidy pandas frame: what each point is, and the numbers that sum it up."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import yaml

from rl_design_space.errors import ConfigError
from rl_design_space.learning.measures import SCALARS

if TYPE_CHECKING:
    import pandas as pd

    from rl_design_space.tracking.queries import Found

#: A number as Python writes it and YAML 1.1 takes for text.
_SMALL = re.compile(r"-?\d+e[+-]\d+")
#: The param that says what a component of one's own was recognised by, after its option's.
_SOURCE = ".source"
#: A tag for each study.
_STUDY_TAG = "study."
#: Columns of a frame of runs that are neither params nor scalars; its index is `run_id`.
ABOUT = ("run_id", "name", "fingerprint", "studies", "started", "ended", "artifacts")


def frame_of(found: Iterable[Found]) -> pd.DataFrame:
    """A row a run, by its id.

    Returns:
        `name`, `fingerprint`, `studies` (names, separated by spaces), `started` and `ended` (UTC), `artifacts` (where
        they are); a column for every param, numbers if all are; and the scalars.
    """
    import pandas as pd

    runs = sorted(found, key=lambda run: (run.started, run.run_id))
    index = pd.Index([run.run_id for run in runs], name="run_id")
    columns: dict[str, Any] = {
        "name": [run.name for run in runs],
        "fingerprint": [run.tags.get("fingerprint") for run in runs],
        "studies": [" ".join(sorted(_studies(run.tags))) for run in runs],
        "started": _times(run.started for run in runs),
        "ended": _times(run.ended for run in runs),
        "artifacts": [run.artifacts for run in runs],
    }
    for name in sorted({name for run in runs for name in run.params}):
        texts = [run.params.get(name) for run in runs]
        by_text = {text: typed(text) for text in set(texts)}
        if any(isinstance(value, str) for value in by_text.values()):
            by_text = {text: text for text in by_text}  # one kind of values in a column
        columns[name] = [by_text[text] for text in texts]
    for name in SCALARS:
        columns[name] = pd.array([run.metrics.get(name) for run in runs], dtype="float64")
    return pd.DataFrame(columns, index=index)


def of_study(frame: pd.DataFrame, study: str) -> pd.DataFrame:
    """The runs that belong to a study.

    Raises:
        ConfigError: none does; the studies that there are are named.
    """
    belongs = frame["studies"].map(lambda names: study in names.split(" ")).astype(bool)
    if not belongs.any():
        known = {name for names in frame["studies"].unique() for name in names.split(" ") if name}
        raise ConfigError.unknown("study among these runs", study, known)
    return frame[belongs]


def of_newest_code(frame: pd.DataFrame) -> pd.DataFrame:
    """Runs without those of components whose code was changed since: of each option, the code of its latest run."""
    for name in frame.columns[frame.columns.str.endswith(_SOURCE)]:
        option = name.removesuffix(_SOURCE)
        newest = frame.sort_values("started").groupby(option)[name].last()  # skips runs without a source
        frame = frame[frame[name].isna() | (frame[name] == frame[option].map(newest))]
    return frame


def filtered(found: Sequence[Found], text: str) -> list[Found]:
    """The runs that a filter of MLflow's search finds: `params.reward = 'end_reward' and metrics.total_steps < 9000`.

    Raises:
        ConfigError: it is no filter.
    """
    from types import SimpleNamespace

    from mlflow.exceptions import MlflowException
    from mlflow.utils.search_utils import SearchUtils

    def as_mlflow_has_it(run: Found) -> SimpleNamespace:
        info = SimpleNamespace(
            run_id=run.run_id, run_name=run.name, start_time=run.started, end_time=run.ended, status="FINISHED",
            artifact_uri=run.artifacts,
        )  # fmt: skip
        data = SimpleNamespace(params=run.params, metrics=run.metrics, tags=run.tags)
        return SimpleNamespace(info=info, data=data, inputs=SimpleNamespace(dataset_inputs=[]), found=run)

    try:
        matching = SearchUtils.filter([as_mlflow_has_it(run) for run in found], text)  # type: ignore[no-untyped-call]
        return [each.found for each in matching]
    except MlflowException as error:
        first_line = str(error).splitlines()[0]
        raise ConfigError.at("filter", text, f"should be a filter of MLflow's search: {first_line}") from error


def _times(milliseconds: Iterable[int]) -> pd.DatetimeIndex:
    import numpy as np
    import pandas as pd

    return pd.DatetimeIndex(np.array(list(milliseconds), "datetime64[ms]")).tz_localize("UTC")


def _studies(tags: Mapping[str, str]) -> list[str]:
    return [name.removeprefix(_STUDY_TAG) for name in tags if name.startswith(_STUDY_TAG)]


def typed(text: str | None) -> Any:
    """A param as it was before MLflow made text of it; lists stay text, so that runs can be grouped by them."""
    if text is None:
        return None
    try:
        value = yaml.safe_load(text)
        value = float(value) if isinstance(value, str) and _SMALL.fullmatch(value) else value
    except yaml.YAMLError:
        return text
    return value if isinstance(value, (int, float, bool)) else text
