"""Loading runs: the frame, choosing runs, curves and periods."""

from __future__ import annotations

import sqlite3
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import rl_design_space as rds
from rl_design_space.errors import ConfigError
from tests.tracking.stores import copy_database, import_mlflow, learned, record, tracker_at

POINTS = {
    "ad hoc": (learned("exploration=linear", "exploration.k=0.02"), ("a", "b")),
    "lists": (learned("msa=lengths_2_3", "world.size=[4,5]"), ("a",)),
    "direction": (learned("representation=direction", "task.periods=1"), ()),
}


@pytest.fixture(scope="module")
def folder(empty_database: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Outputs with three runs."""
    import_mlflow()
    folder = tmp_path_factory.mktemp("load")
    copy_database(empty_database, folder / "mlflow.db")
    tracker = tracker_at(folder / "mlflow.db")
    for (planned, curves), studies in POINTS.values():
        record(tracker, replace(planned, studies=studies), curves)
    return folder


@pytest.fixture
def runs(folder: Path):
    return rds.load_runs(outputs=str(folder))


def row(runs, name: str):
    planned = POINTS[name][0][0]
    return runs[runs["fingerprint"] == planned.fingerprint].iloc[0]


def test_a_row_has_the_choices_and_scalars_of_a_point(runs):
    assert len(runs) == 3
    for name, ((planned, curves), studies) in POINTS.items():
        here = row(runs, name)
        assert here["name"] == planned.run_name(planned.parameters)
        assert here["studies"] == " ".join(studies)
        for parameter, value in planned.parameters.items():
            assert here[parameter] in (value, str(value))
        for scalar, value in curves.scalars().items():
            assert here[scalar] == value


def test_numbers_are_numbers_and_choices_that_a_point_lacks_are_missing(runs):
    assert runs["exploration.k"].dropna().tolist() == [0.02]
    assert runs["task.periods"].dtype == np.int64
    assert runs["total_steps_scaled"].isna().sum() == 1
    assert row(runs, "lists")["msa.lengths"] == "[2, 3]"
    assert (runs["ended"] >= runs["started"]).all()


def test_runs_of_a_study(folder: Path):
    of = {study: set(rds.load_runs(study, outputs=str(folder))["name"]) for study in "ab"}
    assert of == {
        study: {planned.run_name(planned.parameters) for (planned, _), has in POINTS.values() if study in has}
        for study in "ab"
    }
    with pytest.raises(ConfigError, match=r"table4: no such study among these runs.*there is a, b"):
        rds.load_runs("table4", outputs=str(folder))


@pytest.mark.parametrize(
    ("text", "names"),
    [
        ("params.representation = 'direction'", {"direction"}),
        ("params.`exploration.k` = '0.02' and metrics.total_steps > 0", {"ad hoc"}),
        ("tags.`study.a` = 'true'", {"ad hoc", "lists"}),
        ("metrics.total_steps < 0", set()),
    ],
)
def test_a_filter_finds_the_same_runs_as_mlflow(text: str, names: set[str], folder: Path):
    from mlflow import MlflowClient

    found = rds.load_runs(filter=text, outputs=str(folder))
    client = MlflowClient(f"sqlite:///{folder}/mlflow.db")
    experiment = client.get_experiment_by_name("design points").experiment_id
    assert set(found.index) == {run.info.run_id for run in client.search_runs([experiment], text)}
    assert set(found["fingerprint"]) == {POINTS[name][0][0].fingerprint for name in names}


def test_an_invalid_filter_is_reported(folder: Path):
    with pytest.raises(ConfigError, match="filter=total_steps is small: should be a filter of MLflow's search"):
        rds.load_runs(filter="total_steps is small", outputs=str(folder))


def test_curves_and_periods_are_loaded_on_demand(runs):
    curves = rds.load_curves(runs, ["steps/mean", "epsilon"])
    assert list(curves.columns) == ["run_id", "trial", "steps/mean", "epsilon"]
    assert len(curves) == 3 * 4
    for name, ((_, expected), _) in POINTS.items():
        run_id = row(runs, name).name
        assert curves[curves["run_id"] == run_id]["steps/mean"].tolist() == expected.curves["steps/mean"].tolist()
        np.testing.assert_array_equal(rds.load_periods(runs, run_id)["steps"], expected.steps)
    with pytest.raises(ConfigError, match=r"steps/meen: no such learning curve; did you mean steps/mean\?"):
        rds.load_curves(runs, ["steps/meen"])
    with pytest.raises(ConfigError, match="nobody: no such run among these 3"):
        rds.load_periods(runs, "nobody")


def test_a_frame_that_names_no_store_is_refused(runs):
    import pandas as pd

    with pytest.raises(ConfigError, match="use rows of a frame that load_runs returned"):
        rds.load_curves(pd.DataFrame(runs.to_dict()))


def test_every_change_of_the_database_is_seen(folder: Path, tmp_path: Path):
    copy_database(folder / "mlflow.db", tmp_path / "mlflow.db")
    before = rds.load_runs(outputs=str(tmp_path))
    with closing(sqlite3.connect(tmp_path / "mlflow.db")) as database:
        database.execute("insert into tags select 'study.new', 'true', run_uuid from runs")
        database.commit()
        after = rds.load_runs(outputs=str(tmp_path))
    assert after.index.equals(before.index)
    assert after["studies"].str.contains("new").all()
    assert not list(tmp_path.glob("*.parquet"))


def test_measures_are_columns_under_their_names(folder: Path):
    specs = ["total_steps", {"steps_after": 2}, "total_steps_scaled,statistic=median", "trials_to"]
    runs = rds.load_runs(outputs=str(folder), measures=specs)
    assert runs.columns[-3:].tolist() == ["steps_after=2", "total_steps_scaled,statistic=median", "trials_to=1.1"]
    for name, ((planned, curves), _) in POINTS.items():
        here, square = row(runs, name), isinstance(planned.point.world.size, int)
        assert here["total_steps"] == curves.scalars()["total_steps"]
        assert here["steps_after=2"] == pytest.approx(curves.steps[:, 2:].sum(axis=1).mean())
        median = np.median(curves.total_steps) * 10 / 4 if square else np.nan
        assert here["total_steps_scaled,statistic=median"] == pytest.approx(median, nan_ok=True)
    with pytest.raises(ConfigError, match="totl: no such measure; did you mean total_steps"):
        rds.load_runs(outputs=str(folder), measures=["totl"])


def test_runs_of_all_kinds_may_lie_beside_complete_ones(folder: Path, tmp_path: Path):
    """Failed, killed and deleted runs, runs of other programs, and runs of earlier layouts."""
    copy_database(folder / "mlflow.db", tmp_path / "mlflow.db")
    before = rds.load_runs(outputs=str(tmp_path))
    with closing(sqlite3.connect(tmp_path / "mlflow.db")) as database, database:
        columns = [row[1] for row in database.execute("pragma table_info(runs)")]

        def copy(**changed: str) -> None:
            values = [f"'{changed[name]}'" if name in changed else name for name in columns]
            chosen = f"from runs where run_uuid = '{before.index[0]}'"
            database.execute(f"insert into runs ({', '.join(columns)}) select {', '.join(values)} {chosen}")

        for kind in ("failed", "running", "killed", "deleted", "other", "earlier", "empty"):
            stage = "deleted" if kind == "deleted" else "active"
            status = kind.upper() if kind in ("failed", "running", "killed") else "FINISHED"
            copy(run_uuid=kind, status=status, lifecycle_stage=stage)
        database.execute("insert into params (key, value, run_uuid) values ('lr', '0.1', 'other')")
        database.execute("insert into tags (key, value, run_uuid) values ('mlflow.user', 'x', 'other')")
        # An earlier layout: fewer params, and none of the later metrics.
        database.execute("insert into params (key, value, run_uuid) values ('world.size', '10', 'earlier')")
        database.execute("insert into tags (key, value, run_uuid) values ('fingerprint', 'f', 'earlier')")
        database.execute(
            "insert into latest_metrics (key, value, timestamp, step, is_nan, run_uuid) "
            "values ('total_steps', 7.0, 0, 0, 0, 'earlier')"
        )
    runs = rds.load_runs(outputs=str(tmp_path))
    assert set(runs.index) == {*before.index, "other", "earlier", "empty"}
    columns = [name for name in before if name != "world.size"]  # a list of one run makes texts of it in both
    pd.testing.assert_frame_equal(runs.loc[before.index, columns], before[columns], check_dtype=False)
    assert runs.loc["earlier", "total_steps"] == 7
    assert runs.loc["earlier", "fingerprint"] == "f"
    assert runs.loc[["other", "empty"], ["total_steps", "representation"]].isna().all(axis=None)
    assert runs["lr"].dropna().to_dict() == {"other": 0.1}
    assert set(rds.load_runs("a", outputs=str(tmp_path))["name"]) == set(before[before["studies"] != ""]["name"])
