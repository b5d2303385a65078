"""Killing the tracker process, or a whole sweep, at chosen stages of writing."""

from __future__ import annotations

import os
import signal
import subprocess
from pathlib import Path

from tests.command_runner import PATIENCE, SCRIPTS, environment

#: A sitecustomize.py, which Python imports at start: it kills the tracker process, or its process group, at stages that
#: files in a folder name, each once: before or after the n-th statement that inserts into a table, or the n-th COPY of
#: PostgreSQL, before or after the n-th commit of a transaction that has inserted runs. The program does not know it.
SABOTAGE = """
import os, re, signal, sys
from contextlib import contextmanager

if "rl_design_space.tracking.process" in sys.orig_argv:
    from sqlalchemy.engine.default import DefaultDialect

    folder, target = os.environ["FAULTS"], os.environ["FAULT_KILLS"]
    counts, written = {}, []

    def strike(stage):
        try:
            os.remove(os.path.join(folder, stage))
        except FileNotFoundError:
            return
        os.kill(os.getpid(), signal.SIGKILL) if target == "tracker" else os.killpg(0, signal.SIGKILL)

    @contextmanager
    def struck(stage):
        if stage is None:
            yield
            return
        number = counts[stage] = counts.get(stage, 0) + 1
        strike(f"before {stage} {number}")
        yield
        strike(f"after {stage} {number}")

    def sabotage(name, stage_of):
        original = getattr(DefaultDialect, name)

        def sabotaged(self, *args, **kwargs):
            with struck(stage_of(*args)):
                return original(self, *args, **kwargs)

        setattr(DefaultDialect, name, sabotaged)

    def table(cursor, statement, *others):
        found = re.match("(?:INSERT INTO|COPY) ([a-z_]+)", statement)
        if found and found[1] == "runs":
            written.append(True)
        return found and found[1]

    def commit(connection):
        if written:
            written.clear()
            return "commit"

    for name, stage_of in (("do_execute", table), ("do_executemany", table), ("do_commit", commit)):
        sabotage(name, stage_of)

    try:
        from psycopg import Cursor
    except ImportError:  # then there is no PostgreSQL
        pass
    else:
        copied = Cursor.copy

        @contextmanager
        def copy(self, statement):
            with struck(table(self, statement)), copied(self, statement) as rows:
                yield rows

        Cursor.copy = copy
"""


class Sabotage:
    """Runs commands whose tracker is killed.

    Args:
        folder: to run them in.
        kills: `tracker`, or `sweep` for all of its processes.
        variables: of the environment, in addition.
    """

    def __init__(self, folder: Path, kills: str, **variables: str) -> None:
        self.folder = folder
        self._faults = folder / "faults"
        for name in ("own", "temporary", "faults"):
            (folder / name).mkdir()
        (folder / "own" / "sitecustomize.py").write_text(SABOTAGE, encoding="utf-8")
        self._environment = environment(folder, FAULTS=str(self._faults), FAULT_KILLS=kills, **variables)

    def run(self, *words: str, faults: tuple[str, ...] = ()) -> tuple[int, str]:
        """Run rl-design-space in a process group of its own; return its exit status and output.

        Args:
            words: arguments.
            faults: stages at which to strike, e.g. `after metrics 2`.
        """
        for fault in faults:
            (self._faults / fault).touch()
        process = subprocess.Popen(
            [str(SCRIPTS / "rl-design-space"), *words],
            cwd=self.folder,
            env=self._environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            start_new_session=True,
        )
        try:
            output, _ = process.communicate(timeout=PATIENCE)
        finally:
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGKILL)
        assert not list(self._faults.iterdir()), f"a fault did not happen; {output}"
        return process.returncode, output
