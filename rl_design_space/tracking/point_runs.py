"""Which run records a point, in a store that several processes write to and that has no transactions."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import TYPE_CHECKING

from rl_design_space.tracking.store_errors import StoreUnavailableError
from rl_design_space.tracking.tags import FINGERPRINT_TAG, INCOMPLETE_TAG, SPOOL_TAG, of_any_command

if TYPE_CHECKING:
    from mlflow.entities import Run

    from rl_design_space.tracking.client_runs import ClientRuns

#: How often runs are settled, which another process may change at that time.
_ATTEMPTS = 20


class PointRuns:
    """The runs of points in an experiment; `settle` leaves one complete run for each point.

    MLflow's API has neither locks nor conditions: two machines that deliver the same point at once both find nothing,
    and both write a run. So each of them looks again after its run is FINISHED. The one that looks last sees all runs,
    and all of them choose alike: the run whose learning ended first stays, the others become KILLED. It does not matter
    when a process dies in between: its record is still pending, and its delivery looks again.

    Runs are not deleted, because MLflow's permission to edit does not include that.

    Args:
        runs: of the store.
        experiment: id of the experiment.
        spools: identities of the spool whose delivery lock is held.
    """

    def __init__(self, runs: ClientRuns, experiment: str, spools: Collection[str]) -> None:
        self._runs = runs
        self._experiment = experiment
        self._spools = spools

    def settle(self, fingerprint: str, tags: Mapping[str, str]) -> Run | None:
        """Return the run of a point: the complete one, or one to continue that was begun from this spool.

        Args:
            fingerprint: of the point.
            tags: of studies and precisions that its complete run gets.

        Raises:
            StoreUnavailableError: the store does not keep what it has accepted.
        """
        for _ in range(_ATTEMPTS):
            runs = self._runs.find(self._experiment, FINGERPRINT_TAG, fingerprint)
            begun = [
                run for run in runs if run.info.status == "RUNNING" and run.data.tags.get(SPOOL_TAG) in self._spools
            ]
            complete = sorted((run for run in runs if run.info.status == "FINISHED"), key=_order)
            if not complete:
                return next(iter(begun), None)
            kept, others = complete[0], [*complete[1:], *begun]
            wanted = {**_tags(complete), **tags}
            if not others and wanted.items() <= kept.data.tags.items():
                return kept
            self._keep(kept.info.run_id, wanted, others)
        raise StoreUnavailableError(f"run {kept.info.run_id}: what the store has accepted is not there")

    def _keep(self, run_id: str, tags: Mapping[str, str], others: Sequence[Run]) -> None:
        """Add tags to a run, and mark the other ones of its point as KILLED."""
        self._runs.tag(run_id, tags)
        for run in others:
            self._runs.tag(run.info.run_id, {INCOMPLETE_TAG: f"its point is recorded by run {run_id}"})
            self._runs.end(run.info.run_id, "KILLED")


def _order(run: Run) -> tuple[int, str]:
    return run.info.end_time, run.info.run_id


def _tags(runs: Sequence[Run]) -> dict[str, str]:
    return {name: value for run in runs for name, value in of_any_command(run.data.tags).items()}
