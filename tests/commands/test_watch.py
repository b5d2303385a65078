"""The subcommand `watch`: a period of a recorded run, or of overrides, in the terminal and as files."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from rl_design_space.commands import words
from rl_design_space.errors import ConfigError
from rl_design_space.learning.result import read_saved
from tests.tracking.stores import copy_database, learned, record, tracker_at

SMALL = ("world.size=4", "task.goals=2", "task.periods=3", "task.trials=4")


@pytest.fixture
def say(tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch):
    """Run the subcommand; return what it prints."""
    monkeypatch.setattr("rl_design_space.commands.terminal.console.width", 200, raising=False)

    def run(*arguments: str) -> tuple[str, str]:
        words.run("watch", [*arguments, f"outputs={tmp_path}"])
        printed = capsys.readouterr()
        return printed.out, printed.err

    return run


def test_a_point_that_was_not_recorded_is_drawn(say, tmp_path: Path):
    out, err = say(*SMALL, "period=1", "trial=first", "--animate", "gif", "--frames", "2")
    first, *others = out.splitlines()
    assert first.startswith("world.size=4 task.goals=2 task.periods=3 task.trials=4, period 1: ")
    assert others[0].startswith("after trial 0: ")
    heading, *grid = others[2:7]
    assert heading.split() == ["to", "goal", "1", "to", "goal", "2"]
    assert all(set(line) <= set("→←↑↓+·•S12 ") for line in grid)
    assert sum(line.count("S") for line in grid) == 1
    paths = [Path(line) for line in others[-3:]]
    stem = paths[2].stem
    assert {path.name for path in paths} == {f"{stem}-trial-0.png", f"{stem}-trial-0.svg", f"{stem}.gif"}
    assert all(path.parent == tmp_path / "report" and path.exists() for path in paths)
    assert not err


def test_a_run_is_found_by_its_id_or_its_fingerprint(say, tmp_path: Path, empty_database: Path):
    copy_database(empty_database, tmp_path / "mlflow.db")
    planned, curves = learned()
    run = record(tracker_at(tmp_path / "mlflow.db"), planned, curves)
    out, err = say(run.run_id[:10])
    worst = int(curves.total_steps.argmax())
    assert f", period {worst} (worst of 3 periods): {curves.steps[worst].sum():,} steps" in out
    assert f"/watch-{run.run_id[:8]}-period-{worst}-trial-3.png" in out
    assert not err
    path = Path(run.artifacts.removeprefix("file://")) / "periods.npz"
    arrays = read_saved(path)
    arrays["steps"][worst, 0] += 1
    np.savez(path, **arrays)
    _, err = say(planned.fingerprint[:12])
    assert "these are not the recorded steps" in err
    with pytest.raises(ConfigError, match="zz: no complete run has an id or fingerprint that begins with this"):
        say("zz")
    with pytest.raises(ConfigError, match=r"seed=3: beside the run .* only period=, trial= and settings"):
        say(run.run_id, "seed=3")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("period=3",), r"period=3: should be a number from 0 to 2, or worst, median or best"),
        (("period=0", "trial=-1"), r"trial=-1: should be a number from 0 to 3, or worst, .*last"),
        (("period=0", "--frames", "1"), r"--frames=1: should be a number of at least 2"),
    ],
)
def test_what_there_is_not_is_refused(arguments: tuple[str, ...], message: str, say):
    with pytest.raises(ConfigError, match=message):
        say(*SMALL, *arguments)
