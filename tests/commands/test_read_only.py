"""Commands on a finished store that cannot be written to: what only reads it works, all else names the folder."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.command_runner import PATIENCE, environment
from tests.tracking.stores import copy_database, learned, record, tracker_at

#: Runs words of the command line one after the other, and prints how each ends and what is said about errors.
SCRIPT = """
import io, json, sys
from contextlib import redirect_stdout

from rl_design_space.commands import figure_words
from rl_design_space.commands.words import rerun, store, sync, ui
from rl_design_space.errors import ConfigError
from rl_design_space.run.settings import settings_of, store_of
from rl_design_space.tracking.address import sqlite_path
from rl_design_space.tracking.read_only import unwritable

def said(word):
    try:
        return str(word())
    except ConfigError as error:
        return f"error: {error}"
    except SystemExit as ended:
        return f"status {ended.code}"

def served():
    with ui._writable(store_of([])) as tracking:
        return "a copy" if not unwritable(sqlite_path(tracking.uri)) else tracking.uri

heatmap = ["--rows", "representation", "--cols", "seed"]
elsewhere = ["outputs=elsewhere", "tracking.uri=sqlite:///outputs/mlflow.db"]
run_id = store_of([]).reader().runs()[0].run_id
answers = {
    "status": said(lambda: store.main(["status", "--check"])),
    "rerun": said(lambda: rerun.main([run_id])),
    "report": said(lambda: figure_words.main("heatmap", heatmap)),
    "report elsewhere": said(lambda: len(figure_words.main("heatmap", [*heatmap, *elsewhere]))),
    "record": said(lambda: store_of([]).open()),
    "forget": said(lambda: store.main(["forget", run_id])),
    "compact": said(lambda: store.main(["compact"])),
    "sync": said(lambda: sync.main([])),
    "ui": said(served),
}
print(json.dumps(answers))
"""


@pytest.fixture
def protected(empty_database: Path, tmp_path: Path) -> list[str]:
    """Make `outputs` a folder with a finished store and a pending record; return how to start a command beside it."""
    database = tmp_path / "mlflow.db"
    copy_database(empty_database, database)
    tracker = tracker_at(database)
    for overrides in ((), ("seed=1",)):
        record(tracker, *learned(*overrides))
    outputs = tmp_path / "outputs"
    outputs.mkdir()
    for path in (database, tmp_path / "artifacts", tmp_path / "spool"):
        path.rename(outputs / path.name)
    next((outputs / "spool").iterdir()).joinpath("1-point-x.record").touch()
    if os.geteuid():
        for path in [*outputs.rglob("*"), outputs]:
            path.chmod(0o555 if path.is_dir() else 0o444)
        return []
    # Permissions do not stop root.
    mount = 'mount --bind "$0" "$0" && mount -o remount,bind,ro "$0" && exec "$@"'
    words = ["unshare", "--mount", "sh", "-c", mount, str(outputs)]
    if not shutil.which("unshare") or subprocess.run([*words, "true"], check=False, timeout=PATIENCE).returncode:
        pytest.skip("root may not mount a read-only folder here")
    return words


def test_what_only_reads_works_and_all_else_names_the_folder(protected: list[str], tmp_path: Path):
    done = subprocess.run(
        [*protected, sys.executable, "-c", SCRIPT],
        cwd=tmp_path,
        env=environment(tmp_path, TMPDIR="/tmp"),
        capture_output=True,
        text=True,
        timeout=PATIENCE,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    answers = json.loads(done.stdout.splitlines()[-1])
    why = "permission denied" if os.geteuid() else "read-only file system"
    outputs = tmp_path / "outputs"
    remedy = "outputs=DIR or tracking.uri=URI names another place, such as a copy of this one"
    refused = f"error: {outputs}: cannot be written to ({why}); {remedy}"
    spool = next((outputs / "spool").iterdir())
    assert answers == {
        "status": "None",
        "rerun": "status 0",
        "report": f"error: outputs/report: cannot be written to ({why}); "
        "outputs=DIR tracking.uri=sqlite:///outputs/mlflow.db writes elsewhere",
        "report elsewhere": "4",
        "record": refused.replace(f"{outputs}", "outputs/spool"),
        "forget": refused,
        "compact": refused,
        "sync": refused.replace(str(outputs), str(spool)),
        "ui": "a copy",
    }
