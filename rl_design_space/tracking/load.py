"""Recorded runs as pandas frames and NumPy arrays.

import rl_design_space as rds

runs = rds.load_runs(study="table4")                        # a row a run: choices and scalars
late = rds.load_runs(study="table4", measures=["steps_after=30"])["steps_after=30"]
runs.groupby("representation")["total_steps"].mean()
curves = rds.load_curves(runs, ["steps/mean"])              # a row a run and trial
steps = rds.load_periods(runs, runs.index[0])["steps"]      # (periods, trials)
"""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from numpy.typing import NDArray

from rl_design_space.config.build import construct
from rl_design_space.errors import ConfigError
from rl_design_space.learning.measures import canonical
from rl_design_space.tracking.backends import MlflowTracking
from rl_design_space.tracking.read import RunReader
from rl_design_space.tracking.tracker import StoredRun

if TYPE_CHECKING:
    import pandas as pd

#: Attribute of a frame that names the store it was loaded from.
_STORE = "store"


def load_runs(
    study: str | None = None,
    filter: str | None = None,  # noqa: A002 - MLflow's word
    *,
    where: Mapping[str, Any] = MappingProxyType({}),
    outdated: bool = False,
    measures: Sequence[str | Mapping[str, Any]] = (),
    outputs: str = "outputs",
    uri: str | None = None,
    experiment: str = "design points",
) -> pd.DataFrame:
    """Return the complete runs, a row for each, by run id.

    Of each component of your own, the runs of its newest recorded code count; a warning tells how many were left out.

    Args:
        study: return only the runs of this study.
        filter: return only the runs that match this filter of MLflow's search: `params.reward = 'end_reward'`.
        where: return only the runs that have these values, under the names of the command line:
            `{"exploration": "linear", "world.size": [10, 20]}`; a list means any of them.
        outdated: whether runs of earlier code of your components are returned, too; they are if `filter` or `where`
            names it, as `representation.source`.
        measures: computed from the periods of each run, as columns under their names in text, such as `steps_after=30`:
            see docs/reports.md. A trial that is never reached is the number of trials: a lower bound. NaN of runs that
            kept their learning curves alone.
        outputs: folder that commands wrote into.
        uri: of the store, if it is not the database in that folder.
        experiment: name of the experiment that holds the runs.

    Returns:
        Columns `name`, `fingerprint`, `studies`, `started`, `ended`, `artifacts`; a column for each choice, under its
        name on the command line, numbers as numbers; and the scalars, see `LearningCurves.scalars`.

    Raises:
        ConfigError: there is no such store, experiment, study, parameter or measure, or the filter is not valid.
    """
    names = [canonical(spec) for spec in measures]
    address = {"uri": uri or f"sqlite:///{outputs}/mlflow.db", "experiment": experiment}
    options = construct(MlflowTracking, address, "tracking")
    reader = options.reader()
    frame, left_out = reader.select(study, filter, where, outdated=outdated)
    if left_out:
        warnings.warn(f"{left_out}; outdated=True includes them", stacklevel=2)
    if new := [name for name in names if name not in frame]:
        frame[new] = reader.measured(frame, new)
    frame.attrs[_STORE] = {"uri": options.uri, "experiment": experiment}
    return frame


def load_curves(runs: pd.DataFrame, names: Iterable[str] = ("steps/mean",)) -> pd.DataFrame:
    """Return learning curves of runs, a row for each run and trial: `run_id`, `trial`, and a column for each name.

    Args:
        runs: rows of a frame that `load_runs` returned.
        names: names of curves, see `LearningCurves.curves`.

    Raises:
        ConfigError: there is no such curve, or the frame does not come from `load_runs`.
    """
    return _reader(runs).curves(runs, names)


def load_periods(runs: pd.DataFrame, run_id: str) -> dict[str, NDArray[Any]]:
    """Return the arrays that were recorded for a run.

    Args:
        runs: a frame that `load_runs` returned.
        run_id: index of one of its rows.

    Returns:
        `steps` and `success` (periods, trials), `optimum` (periods,), `rows` (periods, 2), and every curve (trials,).

    Raises:
        ConfigError: the run is not in the frame.
    """
    if run_id not in runs.index:
        raise ConfigError(f"{run_id}: no such run among these {len(runs):,}")
    return _reader(runs).periods(StoredRun(run_id, artifacts=str(runs.loc[run_id, "artifacts"])))


def _reader(runs: pd.DataFrame) -> RunReader:
    if _STORE not in runs.attrs:
        raise ConfigError("the frame does not name its store: use rows of a frame that load_runs returned")
    return MlflowTracking(**runs.attrs[_STORE]).reader()
