"""What reports read runs with: a reader of a store, of no runs, and of those that were looked up."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from pathlib import Path
from typing import Any, Protocol

from numpy.typing import NDArray

from rl_design_space._ahead import THREADS
from rl_design_space.tracking.tracker import StoredRun


class Reader(Protocol):
    """A reader of complete runs of design points."""

    @property
    def in_flight(self) -> int:
        """Number of runs whose files are best read at the same time."""
        ...

    def finished(self, fingerprints: Collection[str]) -> dict[str, StoredRun]:
        """Return the complete runs among these points, by fingerprint."""
        ...

    def periods(self, run: StoredRun) -> dict[str, NDArray[Any]]:
        """Return the arrays of a run: `steps` and `success` (periods, trials), `optimum`, `rows`, every curve."""
        ...

    def config(self, run: StoredRun) -> dict[str, Any]:
        """Return the resolved config of a run."""
        ...

    def link(self, ui: str, study: str) -> str:
        """Return the address of a study's runs in an MLflow UI."""
        ...

    def attach(self, study: str, paths: Sequence[Path]) -> None:
        """Add files to the summary run of the last sweep of a study, if there is one."""
        ...


class NoRuns:
    """A reader without runs, for reports that need none."""

    in_flight = THREADS

    def finished(self, fingerprints: Collection[str]) -> dict[str, StoredRun]:
        return {}

    def periods(self, run: StoredRun) -> dict[str, NDArray[Any]]:
        raise LookupError(f"no run was recorded: {run.run_id}")

    def config(self, run: StoredRun) -> dict[str, Any]:
        raise LookupError(f"no run was recorded: {run.run_id}")

    def link(self, ui: str, study: str) -> str:
        return ui

    def attach(self, study: str, paths: Sequence[Path]) -> None:
        pass


class FoundRuns:
    """A reader that has looked up the points of a study, so that no part of its report does so again.

    Args:
        reader: of the tracking store.
        fingerprints: of the points.
        on_read: called when this process has read the arrays of a run.
    """

    def __init__(
        self, reader: Reader, fingerprints: Collection[str], on_read: Callable[[], None] | None = None
    ) -> None:
        self._reader, self._on_read = reader, on_read
        self._points = frozenset(fingerprints)
        self._found = reader.finished(fingerprints)

    @property
    def in_flight(self) -> int:
        return self._reader.in_flight

    def finished(self, fingerprints: Collection[str]) -> dict[str, StoredRun]:
        if not self._points.issuperset(fingerprints):
            return self._reader.finished(fingerprints)
        return {fingerprint: self._found[fingerprint] for fingerprint in fingerprints if fingerprint in self._found}

    def periods(self, run: StoredRun) -> dict[str, NDArray[Any]]:
        arrays = self._reader.periods(run)
        if self._on_read:
            self._on_read()
        return arrays

    def __getstate__(self) -> dict[str, Any]:
        # What another process reads is not counted here.
        return {**vars(self), "_on_read": None}

    def config(self, run: StoredRun) -> dict[str, Any]:
        return self._reader.config(run)

    def link(self, ui: str, study: str) -> str:
        return self._reader.link(ui, study)

    def attach(self, study: str, paths: Sequence[Path]) -> None:
        self._reader.attach(study, paths)
