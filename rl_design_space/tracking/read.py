"""The reader of the runs in an MLflow experiment."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from functools import cached_property
from pathlib import Path
from tempfile import TemporaryDirectory
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, TypeVar
from urllib.parse import quote, unquote, urlencode, urlsplit

from numpy.typing import NDArray

from rl_design_space._ahead import THREADS, ahead
from rl_design_space.errors import ConfigError
from rl_design_space.learning.measures import values
from rl_design_space.learning.result import LearningCurves
from rl_design_space.tracking import selection
from rl_design_space.tracking.address import StoreAddress, sqlite_path
from rl_design_space.tracking.artifacts import is_local, write_artifacts
from rl_design_space.tracking.beginnings import beginnings
from rl_design_space.tracking.collection import without_collection
from rl_design_space.tracking.connection import connect
from rl_design_space.tracking.content import CONFIG_FILE, PERIODS_FILE
from rl_design_space.tracking.download import download
from rl_design_space.tracking.queries import queries_of
from rl_design_space.tracking.run_files import DamagedFileError, check_config, check_periods, read_config, read_periods
from rl_design_space.tracking.run_frame import filtered, frame_of, of_study
from rl_design_space.tracking.selection import Where
from rl_design_space.tracking.store_errors import access_error, as_tracking_error, first_line, is_transient
from rl_design_space.tracking.summary import PICTURE_FILE
from rl_design_space.tracking.tags import STUDY_TAG
from rl_design_space.tracking.tracker import Beginning, StoredRun

if TYPE_CHECKING:
    import pandas as pd
    from mlflow import MlflowClient

    from rl_design_space.plan.plan import PlannedPoint
    from rl_design_space.tracking.found_run import FoundRun

Read = TypeVar("Read")

#: Files that a server is asked for at the same time.
_IN_FLIGHT = 6


class RunReader:
    """A reader of the complete runs of design points in an MLflow experiment.

    Args:
        address: of the store.

    Raises:
        ConfigError: there is no such store or experiment.
        StoreUnavailableError: the store cannot be reached at the moment.
    """

    def __init__(self, address: StoreAddress) -> None:
        database = sqlite_path(address.uri)
        if database and not database.exists():
            raise ConfigError.at("tracking.uri", address.uri, "no run has been recorded there yet")
        self._address = address
        self._queries = queries_of(address)
        self._experiment = self._queries.experiment

    def __reduce__(self) -> tuple[type[RunReader], tuple[StoreAddress]]:
        return RunReader, (self._address,)

    @property
    def in_flight(self) -> int:
        """Number of runs whose files are best read at the same time."""
        return _IN_FLIGHT if self._address.is_server else THREADS

    def finished(self, fingerprints: Collection[str]) -> dict[str, StoredRun]:
        """Return the complete runs among these points, by fingerprint."""
        return self._queries.finished(fingerprints)

    def beginnings(self, points: Collection[PlannedPoint]) -> dict[str, Beginning]:
        """Return a run of each of these points with another number of periods, see `Tracker.beginnings`."""
        return beginnings(points, self._queries.period_counts(), self._queries.finished)

    def runs(self) -> list[FoundRun]:
        """Return all complete runs."""
        return self._queries.runs()

    def frame(self) -> pd.DataFrame:
        """Return a tidy frame of all complete runs, see `run_frame.frame_of`."""
        with without_collection():
            return frame_of(self._queries.runs())

    def select(
        self,
        study: str | None = None,
        filter: str | None = None,  # noqa: A002
        where: Where = MappingProxyType({}),
        *,
        outdated: bool = False,
    ) -> tuple[pd.DataFrame, str]:
        """Return a tidy frame of runs, see `run_frame.frame_of`, and a note on those left out; empty if none were.

        Args:
            study: return only the runs of this study.
            filter: return only the runs that match this filter of MLflow's search.
            where: return only the runs that have these values of parameters; a list means any of them.
            outdated: whether runs of earlier code are included, see `selection`; they are, too, if the filter or
                `where` names the code of a component, such as `representation.source`.

        Raises:
            ConfigError: there is no such study or parameter, or the filter is not valid.
        """
        with without_collection():
            found = every = self._queries.runs()
            if filter is not None:
                found = filtered(found, filter)
            found = selection.chosen(found, where)
            frame = frame_of(found)
        if study is not None:
            frame = of_study(frame, study)
        if outdated or any(selection.SOURCE in name for name in (filter or "", *where)):
            return frame, ""
        old = {run_id: what for run_id, what in selection.outdated(every).items() if run_id in frame.index}
        return (frame.drop(list(old)) if old else frame), selection.left_out(old, len(frame))

    def curves(self, runs: pd.DataFrame, names: Iterable[str]) -> pd.DataFrame:
        """Return learning curves of runs, a row for each run and trial: `run_id`, `trial`, and a column for each name.

        Args:
            runs: a frame of runs.
            names: names of curves, see `learning.measures`.

        Raises:
            ConfigError: there is no such curve.
        """
        import pandas as pd

        names = list(names)
        parts = []
        for run_id, arrays in self.arrays(runs):
            for name in names:
                if name not in arrays or arrays[name].ndim != 1:
                    raise ConfigError.unknown("learning curve", name, [each for each in arrays if "/" in each])
            part = pd.DataFrame({name: arrays[name] for name in names})
            parts.append(part.rename_axis("trial").reset_index().assign(run_id=run_id))
        table = pd.concat(parts, ignore_index=True) if parts else pd.DataFrame(columns=["trial", *names, "run_id"])
        return table[["run_id", "trial", *names]]

    def measured(self, runs: pd.DataFrame, names: Sequence[str]) -> pd.DataFrame:
        """Return measures of runs, a column for each name; NaN of runs that kept their learning curves alone.

        Args:
            runs: a frame of runs.
            names: names of measures.

        Raises:
            ConfigError: there is no such measure, or it cannot be computed.
            DamagedFileError: the periods of a run cannot be read.
        """
        import pandas as pd

        sides = runs["world.size"] if "world.size" in runs else pd.Series(index=runs.index, dtype=float)
        rows = []
        for (_, arrays), side in zip(self.arrays(runs), sides, strict=True):
            result = LearningCurves.found(arrays, side)
            rows.append(values(names, result) if result else dict.fromkeys(names, float("nan")))
        return pd.DataFrame(rows, index=runs.index, columns=list(names), dtype="float64")

    def arrays(self, runs: pd.DataFrame) -> Iterator[tuple[str, dict[str, NDArray[Any]]]]:
        """Yield the id and the arrays of each run of a frame, some of them read ahead.

        Raises:
            DamagedFileError: those of a run cannot be read.
        """
        stored = [StoredRun(str(run_id), artifacts=str(place)) for run_id, place in runs["artifacts"].items()]
        for run, arrays in zip(stored, ahead(self.periods, stored, self.in_flight), strict=True):
            yield run.run_id, arrays

    def periods(self, run: StoredRun) -> dict[str, NDArray[Any]]:
        """Return the arrays of a run's artifact.

        Raises:
            DamagedFileError: they cannot be read.
        """
        return self._artifact(run, PERIODS_FILE, read_periods)

    def config(self, run: StoredRun) -> dict[str, Any]:
        """Return the resolved config of a run.

        Raises:
            DamagedFileError: it cannot be read.
        """
        return self._artifact(run, CONFIG_FILE, read_config)

    def check(self, run: FoundRun) -> None:
        """Check that the files of a run are what was recorded.

        Raises:
            DamagedFileError: one of them cannot be read, or does not agree with what the store knows of the run.
        """
        stored = StoredRun(run.run_id, artifacts=run.artifacts)
        check_periods(run, self.periods(stored))
        check_config(run, self.config(stored))

    def link(self, ui: str, study: str) -> str:
        """Return the address of a study's runs in an MLflow UI."""
        wanted = urlencode({"searchFilter": f'tags."{STUDY_TAG}{study}" = "true"'}, quote_via=quote)
        return f"{ui.rstrip('/')}/#/experiments/{self._experiment}/runs?{wanted}"

    def run_link(self, ui: str, run_id: str) -> str:
        """Return the address of a run in an MLflow UI."""
        return f"{ui.rstrip('/')}/#/experiments/{self._experiment}/runs/{run_id}"

    def attach(self, study: str, paths: Sequence[Path]) -> None:
        """Add files to the summary run of the last sweep of a study, if there is one; its page shows the first picture.

        Raises:
            OSError: its folder cannot be written to.
        """
        sweep = self._queries.newest_sweep(study)
        if sweep is None:
            return
        pictures = [path for path in paths if path.suffix == Path(PICTURE_FILE).suffix]
        main = {PICTURE_FILE: pictures[0].read_bytes()} if pictures else {}
        local = self._local_folder(sweep.artifacts) if is_local(sweep.artifacts) else None
        with TemporaryDirectory() as temporary:
            folder = local or Path(temporary)
            write_artifacts(str(folder), main)
            write_artifacts(str(folder / "report"), {path.name: path.read_bytes() for path in paths})
            if local is None:
                self._client.log_artifacts(sweep.run_id, temporary)

    def _artifact(self, run: StoredRun, name: str, read: Callable[[str, Path], Read]) -> Read:
        if folder_here := self._local_folder(run.artifacts):
            return read(run.run_id, folder_here / name)
        with TemporaryDirectory() as folder:
            try:
                path = download(self._client, run, name, Path(folder))
            except Exception as error:
                if is_transient(error) or access_error(self._address.uri, error):
                    raise as_tracking_error(self._address.uri, error) from error
                raise DamagedFileError(run.run_id, name, first_line(error)) from error
            return read(run.run_id, path)

    def _local_folder(self, uri: str) -> Path | None:
        """Return the folder of a run's files if it is on this machine: as recorded, or else beside the database."""
        place = urlsplit(uri)
        if place.scheme not in ("", "file") or not place.path:
            return None
        folder, database = Path(unquote(place.path)), sqlite_path(self._address.uri)
        if database and not folder.exists():  # copied or mounted at another path
            beside = database.parent.joinpath("artifacts", *folder.parts[-3:])
            return beside if beside.exists() else folder
        return folder

    @cached_property
    def _client(self) -> MlflowClient:
        return connect(self._address.uri)
