"""Tracked runs, read back."""

from __future__ import annotations

import os
from collections.abc import Collection, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Protocol
from urllib.parse import quote, urlencode

from numpy.typing import NDArray

from rl_design_space.errors import ConfigError
from rl_design_space.tracking.index import finished_runs
from rl_design_space.tracking.record import PERIODS_FILE, STUDY_TAG, read_periods
from rl_design_space.tracking.store import connect, sqlite_path
from rl_design_space.tracking.tracker import StoredRun


class Reader(Protocol):
    """Reads complete runs of design points."""

    def finished(self, fingerprints: Collection[str]) -> dict[str, StoredRun]:
        """The complete runs among these points, by fingerprint."""
        ...

    def periods(self, run: StoredRun) -> dict[str, NDArray[Any]]:
        """The arrays of a run's artifact: `steps` and `success` (periods, trials), `optimum`, `rows`, every curve."""
        ...

    def link(self, ui: str, study: str) -> str:
        """Address of a study's runs in an MLflow UI."""
        ...

    def attach(self, study: str, paths: Sequence[Path]) -> None:
        """Keep files with the summary run of the last sweep that a study belongs to, if there is one."""
        ...


class NoRuns:
    """Stands for a reader where a report needs no runs."""

    def finished(self, fingerprints: Collection[str]) -> dict[str, StoredRun]:
        return {}

    def periods(self, run: StoredRun) -> dict[str, NDArray[Any]]:
        raise LookupError(f"no run was recorded: {run.run_id}")

    def link(self, ui: str, study: str) -> str:
        return ui

    def attach(self, study: str, paths: Sequence[Path]) -> None:
        pass


class RunReader:
    """Reads complete runs of design points from an MLflow experiment.

    Raises:
        ConfigError: there is no such store or experiment.
    """

    def __init__(self, uri: str, experiment: str, sweeps: str) -> None:
        database = sqlite_path(uri)
        if database and not database.exists():
            raise ConfigError.at("tracking.uri", uri, "no run has been recorded there yet")
        self._uri = uri
        self._client = connect(uri)
        known = self._client.get_experiment_by_name(experiment)
        if known is None:
            raise ConfigError.at("tracking.experiment", experiment, f"there is no such experiment in {uri}")
        self._experiment = known.experiment_id
        summaries = self._client.get_experiment_by_name(sweeps)
        self._sweeps = summaries.experiment_id if summaries else None

    def finished(self, fingerprints: Collection[str]) -> dict[str, StoredRun]:
        """The complete runs among these points, by fingerprint."""
        return finished_runs(self._client, self._uri, self._experiment, fingerprints)

    def link(self, ui: str, study: str) -> str:
        wanted = urlencode({"searchFilter": f'tags."{STUDY_TAG}{study}" = "true"'}, quote_via=quote)
        return f"{ui.rstrip('/')}/#/experiments/{self._experiment}/runs?{wanted}"

    def attach(self, study: str, paths: Sequence[Path]) -> None:
        if self._sweeps is None:
            return
        wanted = f"tags.`{STUDY_TAG}{study}` = 'true'"
        newest = ["attributes.start_time DESC"]
        for run in self._client.search_runs([self._sweeps], wanted, max_results=1, order_by=newest):
            for path in paths:
                self._client.log_artifact(run.info.run_id, str(path), "report")

    def periods(self, run: StoredRun) -> dict[str, NDArray[Any]]:
        os.environ.setdefault("MLFLOW_ENABLE_ARTIFACTS_PROGRESS_BAR", "false")
        with TemporaryDirectory() as folder:
            return read_periods(Path(self._client.download_artifacts(run.run_id, PERIODS_FILE, folder)))
