"""The commands of docs/server.md and docs/clusters.md work with a server and clusters of this machine."""

from __future__ import annotations

from pathlib import Path

import pytest

import rl_design_space as rds
from tests.documented import DOCS, Typed, parts_of, run
from tests.servers import MlflowServer, needs_postgres
from tests.tracking.stores import copy_database, import_mlflow

#: Placeholders that a reader replaces, and the key of clusters that are started elsewhere, which are not tested.
_SERVER, _RUN, _PART, _ELSEWHERE = (
    "http://trackinghost:5000",
    "RUN_ID",
    "$SLURM_ARRAY_TASK_ID",
    "hydra.launcher.address=",
)


def typed(page: str) -> list[Typed]:
    return [part for part in parts_of(DOCS / page) if isinstance(part, Typed)]


@pytest.fixture(scope="module")
def folder(empty_database: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("team")
    (folder / "temporary").mkdir()
    copy_database(empty_database, folder / "outputs" / "mlflow.db")
    return folder


@needs_postgres
def test_the_commands_for_a_server_work(mlflow_server: MlflowServer, folder: Path):
    import_mlflow()
    commands = typed("server.md")
    assert len(commands) > 3
    for command in commands:
        words = [word.replace(_SERVER, mlflow_server.uri) for word in command.words]
        if _RUN in words:
            words[words.index(_RUN)] = rds.load_runs(study="table4", uri=mlflow_server.uri).index[0]
        done = run(tuple(words), folder)
        assert done.returncode == 0, words
        # Reports print their main numbers; other commands have nothing to say there.
        assert ("Table 4" in done.stderr and "warning" not in done.stderr.lower()) or done.stderr == "", words
        assert done.stdout


@needs_postgres
def test_the_commands_for_clusters_work(mlflow_server: MlflowServer, folder: Path):
    commands = [command.words for command in typed("clusters.md")]
    here = [words for words in commands if not any(_ELSEWHERE in word for word in words)]
    assert len(here) == len(commands) - 2 > 0
    for words in here:
        done = run(tuple(word.replace(_SERVER, mlflow_server.uri).replace(_PART, "1") for word in words), folder)
        assert done.returncode == 0, done.stdout + done.stderr
        assert "0 failed" in done.stdout
