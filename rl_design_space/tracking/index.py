"""Which points a store has, found in one go."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from typing import TYPE_CHECKING, Any

from rl_design_space.tracking.record import STUDY_TAG
from rl_design_space.tracking.tracker import StoredRun

if TYPE_CHECKING:
    from mlflow import MlflowClient
    from mlflow.entities import Run

#: Up to so many points are asked for one by one; above, all runs are read.
_FEW = 20
_RUNS_PER_PAGE = 1000
_COMPLETE = "attributes.status = 'FINISHED'"


def finished_runs(
    client: MlflowClient, uri: str, experiment: str, fingerprints: Collection[str]
) -> dict[str, StoredRun]:
    """The complete runs of these points in an experiment, by fingerprint.

    Args:
        client: of the store.
        uri: of the store. A database is asked directly: through MLflow, 10,000 runs take 20 seconds.
        experiment: id of the experiment.
        fingerprints: of the points.
    """
    if len(fingerprints) <= _FEW:
        runs = [run for fingerprint in fingerprints for run in _search(client, experiment, fingerprint)]
        found: Iterable[tuple[str, StoredRun]] = map(_stored, runs)
    elif uri.startswith(("http:", "https:", "databricks")):
        found = map(_stored, _search(client, experiment))
    else:
        found = _from_database(uri, experiment)
    wanted = set(fingerprints)
    return {fingerprint: run for fingerprint, run in found if fingerprint in wanted}


def _search(client: MlflowClient, experiment: str, fingerprint: str = "") -> Iterable[Run]:
    wanted = f"{_COMPLETE} and tags.fingerprint = '{fingerprint}'" if fingerprint else _COMPLETE
    token = None
    while True:
        page = client.search_runs([experiment], wanted, max_results=_RUNS_PER_PAGE, page_token=token)
        yield from page
        token = page.token
        if not token:
            return


def _stored(run: Run) -> tuple[str, StoredRun]:
    studies = frozenset(tag.removeprefix(STUDY_TAG) for tag in run.data.tags if tag.startswith(STUDY_TAG))
    return run.data.tags.get("fingerprint", ""), StoredRun(run.info.run_id, studies)


def _from_database(uri: str, experiment: str) -> Iterable[tuple[str, StoredRun]]:
    import sqlalchemy
    from mlflow.store.tracking.dbmodels import models

    run: Any = models.SqlRun
    tag: Any = models.SqlTag
    complete = (
        sqlalchemy.select(tag.run_uuid, tag.key, tag.value)
        .join(run, run.run_uuid == tag.run_uuid)
        .where(run.experiment_id == int(experiment), run.status == "FINISHED", run.lifecycle_stage == "active")
        .where(sqlalchemy.or_(tag.key == "fingerprint", tag.key.startswith(STUDY_TAG, autoescape=True)))
    )
    engine = sqlalchemy.create_engine(uri)
    fingerprints: dict[str, str] = {}
    studies: dict[str, set[str]] = {}
    try:
        with engine.connect() as connection:
            for run_id, key, value in connection.execute(complete):
                if key == "fingerprint":
                    fingerprints[run_id] = value
                else:
                    studies.setdefault(run_id, set()).add(key.removeprefix(STUDY_TAG))
    finally:
        engine.dispose()
    for run_id, fingerprint in fingerprints.items():
        yield fingerprint, StoredRun(run_id, frozenset(studies.get(run_id, ())))
