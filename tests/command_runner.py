"""The real commands, run in a folder of their own."""

from __future__ import annotations

import os
import signal
import sqlite3
import subprocess
import sysconfig
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

from tests.tracking.stores import copy_database

SCRIPTS = Path(sysconfig.get_path("scripts"))

#: Variables that would change what a command does.
_OTHERS = ("HYDRA_", "MLFLOW_", "RL_DESIGN_SPACE_")

Completed = subprocess.CompletedProcess[str]
Command = Callable[..., Completed]


def environment(folder: Path, **more: str) -> dict[str, str]:
    """Variables for a command that runs in a folder: its own temporary folder, wide output, no tracebacks."""
    inherited = {name: value for name, value in os.environ.items() if not name.startswith(_OTHERS)}
    own = {"TMPDIR": str(folder / "temporary"), "PYTHONPATH": str(folder / "own"), "COLUMNS": "400", "NO_COLOR": "1"}
    return {**inherited, **own, **more}


def started(folder: Path, *words: str) -> subprocess.Popen[str]:
    """Begin rl-design-space in a folder; Ctrl-C reaches it even where these tests run in the background."""
    return subprocess.Popen(
        [str(SCRIPTS / "rl-design-space"), *words],
        cwd=folder,
        env=environment(folder),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=heed_interrupts,
    )


def heed_interrupts() -> None:
    """What a shell starts in the background ignores SIGINT, and so does all that it starts."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def commands_in(folder: Path, database: Path | None = None) -> Command:
    """Run a command in a folder; whatever it does, it may write nothing beside its outputs.

    Args:
        folder: made for this.
        database: what new outputs begin with; creating one takes a command seconds.
    """
    (folder / "temporary").mkdir()
    (folder / "own").mkdir()

    def run(*words: str, status: int = 0, outputs: str = "out", **variables: str) -> Completed:
        program, *arguments = words
        full = [str(SCRIPTS / program) if program.startswith("rl-") else program, *arguments, f"outputs={outputs}"]
        if database and not (folder / outputs).exists():
            copy_database(database, folder / outputs / "mlflow.db")
        before = _tree(folder)
        done = subprocess.run(
            full, cwd=folder, env=environment(folder, **variables), capture_output=True, text=True, timeout=120
        )
        assert done.returncode == status, done.stdout + done.stderr
        assert _tree(folder) == before
        return done

    return run


def runs(folder: Path, experiment: str = "design points", outputs: str = "out") -> list[tuple[str, str]]:
    """Name and status of the recorded runs."""
    query = (
        "select runs.name, runs.status from runs join experiments using (experiment_id) "
        "where experiments.name = ? order by runs.start_time"
    )
    with closing(sqlite3.connect(folder / outputs / "mlflow.db")) as database:
        return database.execute(query, [experiment]).fetchall()


def _tree(folder: Path) -> set[Path]:
    """Everything in a folder but what lies in its outputs, and the claims on points of stores that are no file."""
    outside = {path for path in folder.rglob("*") if "__pycache__" not in path.parts}
    allowed = (folder / "out", folder / "temporary" / f"rl-design-space-{os.getuid()}")
    return {path for path in outside if not any(path.is_relative_to(place) for place in allowed)}
