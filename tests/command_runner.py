"""Real commands in folders of their own, and waiting for processes with a limit."""

from __future__ import annotations

import os
import signal
import sqlite3
import subprocess
import sys
import sysconfig
from collections.abc import Callable, Iterator, Mapping
from contextlib import closing, contextmanager, suppress
from pathlib import Path
from threading import Timer
from time import monotonic, sleep
from typing import Any

from tests.tracking.stores import copy_database
from tests.warm import warm

SCRIPTS = Path(sysconfig.get_path("scripts"))

#: Variables that would change what a command does.
_OTHERS = ("HYDRA_", "MLFLOW_", "RL_DESIGN_SPACE_")

#: Seconds that a test waits for a process, or for something to happen, before it fails.
PATIENCE = 240

Completed = subprocess.CompletedProcess[str]
Command = Callable[..., Completed]


def environment(folder: Path, **more: str) -> dict[str, str]:
    """Return the variables of a command that runs in a folder: a temporary folder in it, wide output, no colours."""
    inherited = {name: value for name, value in os.environ.items() if not name.startswith(_OTHERS)}
    own = {"TMPDIR": str(folder / "temporary"), "PYTHONPATH": str(folder / "own"), "COLUMNS": "400", "NO_COLOR": "1"}
    return {**inherited, **own, **more}


@contextmanager
def started(folder: Path, *words: str, **variables: str) -> Iterator[subprocess.Popen[str]]:
    """Start rl-design-space in a folder, and kill it if it still runs when the test no longer needs it.

    Ctrl-C reaches it even where these tests run in the background.
    """
    process = subprocess.Popen(
        [str(SCRIPTS / "rl-design-space"), *words],
        cwd=folder,
        env=environment(folder, **variables),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=heed_interrupts,
    )
    try:
        yield process
    finally:
        if process.poll() is None:
            process.kill()
            process.wait(PATIENCE)


def heed_interrupts() -> None:
    """Undo that a process started by a shell in the background ignores SIGINT, as does all that it starts."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def finished(process: subprocess.Popen[str], seconds: float = PATIENCE) -> Completed:
    """Wait until a process ends and return what it wrote; a process that takes too long is killed.

    Raises:
        subprocess.TimeoutExpired: it was killed.
    """
    try:
        out, err = process.communicate(timeout=seconds)
    except BaseException:  # also what ends a test that takes too long
        process.kill()
        with suppress(subprocess.TimeoutExpired):  # processes that it started may hold its pipes open
            process.communicate(timeout=5)
        raise
    return Completed(process.args, process.returncode, out, err)


def next_line(process: subprocess.Popen[str], stream: str = "stdout", seconds: float = PATIENCE) -> str:
    """Return the next line that a process writes, or an empty string at its end; it is killed if it takes too long."""
    timer = Timer(seconds, process.kill)
    timer.start()
    try:
        line: str = getattr(process, stream).readline()
        return line
    finally:
        timer.cancel()


def wait_until(
    condition: Callable[[], object],
    process: subprocess.Popen[str] | None = None,
    seconds: float = PATIENCE,
    pause: float = 0.01,
) -> None:
    """Wait until a condition holds.

    Args:
        condition: checked again and again.
        process: brings the condition about, so it must not end before.
        seconds: limit after which the test fails.
        pause: seconds between two checks.
    """
    deadline = monotonic() + seconds
    while not condition():
        if process is not None and process.poll() is not None and not condition():
            raise AssertionError(f"the process has ended: {finished(process)}")
        assert monotonic() < deadline, f"not within {seconds} s"
        sleep(pause)


def completed(folder: Path, *words: str, cold: bool = False, **variables: str) -> Completed:
    """Run a command in a folder to its end.

    Args:
        folder: current folder of the command.
        words: a command of this project by its name, or any other program, and arguments.
        cold: whether to start a new interpreter for a command of this project also where a process that has made its
            imports would do, see tests/warm.py; what starts workers gets a new one in any case.
        variables: of the environment.
    """
    program, *arguments = words
    ours = program.startswith("rl-")
    full = [str(SCRIPTS / program) if ours else program, *arguments]
    variables = environment(folder, **variables)
    workers = any(word.startswith("hydra/launcher=") and not word.endswith("=basic") for word in arguments)
    if ours and not cold and not workers:
        return warm().run(full, cwd=folder, env=variables, timeout=PATIENCE)
    return subprocess.run(full, cwd=folder, env=variables, capture_output=True, text=True, timeout=PATIENCE)


def output_of(
    *command: object, cwd: Path | None = None, env: Mapping[str, str] | None = None, seconds: float = PATIENCE
) -> str:
    """Run a command that should succeed and return its standard output."""
    words = [str(word) for word in command]
    done = subprocess.run(words, cwd=cwd, env=env, capture_output=True, text=True, timeout=seconds)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def python(program: str, *arguments: object, **options: Any) -> str:
    """Run a Python program in a new process and return its standard output."""
    return output_of(sys.executable, "-c", program, *arguments, **options)


def commands_in(folder: Path, database: Path | None = None) -> Command:
    """Return a function that runs a command in a folder and checks that it writes nothing beside its outputs.

    It takes the arguments of `completed`, the expected status and the outputs.

    Args:
        folder: empty folder for the commands.
        database: copied into new outputs, because creating one takes a command seconds.
    """
    (folder / "temporary").mkdir()
    (folder / "own").mkdir()

    def run(*words: str, status: int = 0, outputs: str = "out", **others: Any) -> Completed:
        if database and not (folder / outputs).exists():
            copy_database(database, folder / outputs / "mlflow.db")
        before = _tree(folder)
        done = completed(folder, *words, f"outputs={outputs}", **others)
        assert done.returncode == status, done.stdout + done.stderr
        assert _tree(folder) == before
        return done

    return run


def runs(folder: Path, experiment: str = "design points", outputs: str = "out") -> list[tuple[str, str]]:
    """Return name and status of the recorded runs."""
    query = (
        "select runs.name, runs.status from runs join experiments using (experiment_id) "
        "where experiments.name = ? order by runs.start_time"
    )
    with closing(sqlite3.connect(folder / outputs / "mlflow.db")) as database:
        return database.execute(query, [experiment]).fetchall()


def _tree(folder: Path) -> set[Path]:
    """Return all files of a folder except its outputs and the locks of stores that are no file."""
    outside = {path for path in folder.rglob("*") if "__pycache__" not in path.parts}
    allowed = (folder / "out", folder / "temporary" / f"rl-design-space-{os.getuid()}")
    return {path for path in outside if not any(path.is_relative_to(place) for place in allowed)}
