"""Tracked runs in Python: what was recorded, as pandas and NumPy have it.

import rl_design_space as rds

runs = rds.load_runs(study="table4")                        # a row a run: choices and scalars
runs.groupby("representation")["total_steps"].mean()
curves = rds.load_curves(runs, ["steps/mean"])              # a row a run and trial
steps = rds.load_periods(runs, runs.index[0])["steps"]      # (periods, trials)
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from numpy.typing import NDArray

from rl_design_space.errors import ConfigError
from rl_design_space.tracking.backends import MlflowTracking
from rl_design_space.tracking.read import RunReader
from rl_design_space.tracking.tracker import StoredRun

if TYPE_CHECKING:
    import pandas as pd

#: Where a frame says which store it was loaded from.
_STORE = "store"


def load_runs(
    study: str | None = None,
    filter: str | None = None,  # noqa: A002 - MLflow's word
    *,
    outputs: str = "outputs",
    uri: str | None = None,
    experiment: str = "design points",
) -> pd.DataFrame:
    """Complete runs, a row each, by their ids.

    Args:
        study: whose runs, if not all.
        filter: of MLflow's search, that they should fulfil: `params.reward = 'end_reward'`.
        outputs: folder that commands wrote into.
        uri: of the store, if it is not the database in that folder.
        experiment: that holds the runs.

    Returns:
        Columns `name`, `fingerprint`, `studies`, `started`, `ended`, `artifacts`; a column for each choice, under its
        name on the command line, numbers as numbers; and the scalars, see `LearningCurves.scalars`.

    Raises:
        ConfigError: there is no such store, experiment or study, or it is no filter.
    """
    options = MlflowTracking(uri=uri or f"sqlite:///{outputs}/mlflow.db", experiment=experiment)
    frame = options.reader().frame(study, filter)
    frame.attrs[_STORE] = {"uri": options.uri, "experiment": experiment}
    return frame


def load_curves(runs: pd.DataFrame, names: Iterable[str] = ("steps/mean",)) -> pd.DataFrame:
    """Learning curves of some of these runs: `run_id`, `trial`, and a column for each of the names.

    Args:
        runs: as `load_runs` returns them, or some of the rows.
        names: of the curves, see `LearningCurves.curves`.

    Raises:
        ConfigError: there is no such curve, or these are not such runs.
    """
    return _reader(runs).curves(runs, names)


def load_periods(runs: pd.DataFrame, run_id: str) -> dict[str, NDArray[Any]]:
    """Everything that was recorded of a run.

    Args:
        runs: as `load_runs` returns them.
        run_id: of one of them.

    Returns:
        `steps` and `success` (periods, trials), `optimum` (periods,), `rows` (periods, 2), and every curve (trials,).

    Raises:
        ConfigError: it is none of these runs.
    """
    if run_id not in runs.index:
        raise ConfigError(f"{run_id}: none of these {len(runs):,} runs")
    return _reader(runs).periods(StoredRun(run_id, artifacts=str(runs.loc[run_id, "artifacts"])))


def _reader(runs: pd.DataFrame) -> RunReader:
    if _STORE not in runs.attrs:
        raise ConfigError("these runs do not say where they are from: take rows of what load_runs returns")
    return MlflowTracking(**runs.attrs[_STORE]).reader()
