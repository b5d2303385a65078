"""The subcommands for the tracking store: sync, store status, store compact, rerun."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from rl_design_space.commands import figure_words, words
from rl_design_space.errors import ConfigError
from rl_design_space.learning.result import read_saved
from rl_design_space.tracking.mlflow_tracker import MlflowTracker
from tests.tracking.stores import copy_database, learned, record, tracker_at, undelivered_tracker_at


@pytest.fixture
def outputs(empty_database: Path, tmp_path: Path) -> Path:
    copy_database(empty_database, tmp_path / "mlflow.db")
    return tmp_path


@pytest.fixture
def say(outputs: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch):
    """Run a subcommand; return its exit status and its output."""
    monkeypatch.setattr("rl_design_space.commands.terminal.console.width", 200, raising=False)

    def run(word: str, *arguments: str) -> tuple[int, str]:
        status = 0
        try:
            words.run(word, [*arguments, f"outputs={outputs}"])
        except SystemExit as ended:
            status = int(ended.code or 0)
        return status, capsys.readouterr().out

    return run


def undelivered(outputs: Path) -> MlflowTracker:
    """Return a tracker whose records stay pending."""
    return undelivered_tracker_at(outputs / "mlflow.db")


def test_pending_records_are_delivered_once(say, outputs: Path):
    assert say("sync") == (0, f"no pending records in {outputs}/spool\n")
    tracker = undelivered(outputs)
    for override in ("seed=0", "seed=1"):
        tracker.record(*learned(override))
    status, said = say("sync")
    assert status == 0
    assert re.search(r"2 records for sqlite:.* …\n2 records delivered\nno pending records", said)
    assert say("sync") == (0, f"no pending records in {outputs}/spool\n")
    assert len(tracker.finished([learned(seed)[0].fingerprint for seed in ("seed=0", "seed=1")])) == 2


def test_undeliverable_records_are_reported(say, outputs: Path):
    tracker = undelivered(outputs)
    planned, curves = learned()
    tracker.record(planned, curves)
    (path,) = (outputs / "spool").glob("*/*.record")
    path.write_bytes(b"nonsense")
    status, said = say("sync")
    assert status == 1
    assert re.search(r"quarantined, because it cannot be delivered: .*aside/\d+-1-point-", said)


def test_the_state_of_a_store(say, outputs: Path):
    tracker = tracker_at(outputs / "mlflow.db")
    runs = [record(tracker, *learned(override)) for override in ("seed=0", "seed=1", "seed=2")]
    from mlflow import MlflowClient

    client = MlflowClient(f"sqlite:///{outputs}/mlflow.db")
    client.delete_run(runs[0].run_id)
    client.update_run(runs[1].run_id, status="FAILED")
    undelivered(outputs).record(*learned("seed=3"))
    status, said = say("store", "status")
    assert status == 0
    for line in (r"points +1 complete", r"incomplete +1 FAILED", r"deleted +1 runs", r"pending +1 points, 1 records"):
        assert re.search(line, said), said
    status, said = say("store", "compact")
    assert "1 deleted runs removed" in said
    assert re.search(r"deleted +0 runs", said)
    assert not Path(runs[0].artifacts.removeprefix("file://")).exists()
    assert Path(runs[2].artifacts.removeprefix("file://")).exists()


def test_damaged_runs_are_found_and_learned_anew(say, outputs: Path):
    tracker = tracker_at(outputs / "mlflow.db")
    points = [learned(f"seed={seed}") for seed in range(3)]
    runs = [record(tracker, *point) for point in points]
    cut, changed, whole = (Path(run.artifacts.removeprefix("file://")) for run in runs)
    (cut / "periods.npz").write_bytes((whole / "periods.npz").read_bytes()[:200])
    (changed / "config.yaml").write_text((whole / "config.yaml").read_text().replace("seed: 2", "seed: 7"))
    status, said = say("store", "status", "--check")
    assert status == 1
    assert f"damaged: run {runs[0].run_id}: periods.npz: File is not a zip file\n" in said
    assert f"damaged: run {runs[1].run_id}: config.yaml: it says seed=7, recorded was 1\n" in said
    assert "2 damaged runs; to learn their points anew: rl-design-space store forget --damaged" in said
    with pytest.raises(ConfigError, match=rf"run {runs[0].run_id}: periods\.npz is damaged"):
        say("rerun", runs[0].run_id)
    with pytest.raises(ConfigError, match=rf"run {runs[1].run_id}: config\.yaml is damaged"):
        say("rerun", runs[1].run_id)
    with pytest.raises(ConfigError, match=rf"run {runs[0].run_id}: periods\.npz is damaged .*store forget"):
        figure_words.main("curves", ["--by", "seed", f"outputs={outputs}"])
    done = "1 run forgotten; the commands that ran their points learn them anew\n"
    assert say("store", "forget", runs[0].run_id[:12])[1].endswith(done)
    assert f"(run {runs[1].run_id})\n1 run forgotten;" in say("store", "forget", "--damaged")[1]
    fingerprints = [planned.fingerprint for planned, _ in points]
    assert list(tracker.finished(fingerprints)) == fingerprints[2:]
    again = record(tracker, *points[0])
    assert again.run_id not in ("", runs[0].run_id)
    assert say("rerun", again.run_id)[0] == 0
    status, said = say("store", "status", "--check")
    assert status == 0
    assert "the files of all complete runs are as they were recorded" in said


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("forget",), "forget needs the ids of runs, or --damaged"),
        (("compact", "--check"), "--check belongs to status"),
        (("status", "--damaged"), "--damaged belongs to forget"),
    ],
)
def test_flags_of_another_action_are_refused(
    arguments: tuple[str, ...], message: str, capsys: pytest.CaptureFixture[str]
):
    with pytest.raises(SystemExit, match="2"):
        words.run("store", arguments)
    assert message in capsys.readouterr().err


def test_nothing_is_forgotten_if_one_run_is_unknown(say, outputs: Path):
    tracker = tracker_at(outputs / "mlflow.db")
    run = record(tracker, *learned())
    with pytest.raises(ConfigError, match="zzz: no complete run has an id that begins with this"):
        say("store", "forget", run.run_id, "zzz")
    assert tracker.finished([learned()[0].fingerprint])


@pytest.mark.parametrize("arguments", [("store", "status"), ("store", "compact"), ("sync",)])
def test_there_is_no_store_without_tracking(arguments: tuple[str, ...], say):
    with pytest.raises(ConfigError, match="tracking=none: nothing is recorded"):
        say(*arguments, "tracking=none")


def test_an_override_that_is_not_used_is_refused(say):
    with pytest.raises(ConfigError, match=r"seed=3: not a setting; this command takes outputs=…"):
        say("sync", "seed=3")
    with pytest.raises(ConfigError, match=r"study=table4: not a setting of this command, which takes outputs=…"):
        say("store", "status", "study=table4")


def test_a_rerun_gives_identical_results(say, outputs: Path):
    run = record(tracker_at(outputs / "mlflow.db"), *learned("representation=direction", "msa=lengths_2_3"))
    status, said = say("rerun", run.run_id[:8])
    assert status == 0
    assert said.startswith("identical: size=4 direction lengths_2_3 trials=4 periods=3 ")
    assert "12 trials, bit for bit" in said.replace("\n", " ")


def test_a_rerun_with_different_results_is_reported(say, outputs: Path):
    run = record(tracker_at(outputs / "mlflow.db"), *learned())
    path = Path(run.artifacts.removeprefix("file://")) / "periods.npz"
    arrays = read_saved(path)
    arrays["steps"][0, 0] += 1
    np.savez(path, **arrays)
    status, said = say("rerun", run.run_id)
    assert status == 1
    assert said.startswith("different: ")
    assert "in steps" in said


def test_a_rerun_runs_nothing_that_the_run_names(say, outputs: Path):
    run = record(tracker_at(outputs / "mlflow.db"), *learned())
    path = Path(run.artifacts.removeprefix("file://")) / "config.yaml"
    call = f"{{_target_: pathlib.Path.touch, self: {{_target_: pathlib.Path, _args_: [{outputs}/run]}}}}"
    path.write_text(path.read_text().replace("size: 4", f"size: {call}"))
    with pytest.raises(
        ConfigError, match=rf"run {run.run_id}: world\.size\._target_=pathlib.Path.touch: comes from the"
    ):
        say("rerun", run.run_id)
    assert not (outputs / "run").exists()


def test_an_unknown_run_is_refused(say, outputs: Path):
    record(tracker_at(outputs / "mlflow.db"), *learned())
    with pytest.raises(ConfigError, match="ffff: no complete run has an id that begins with this"):
        say("rerun", "ffff")


def test_a_run_without_its_periods_cannot_be_compared(say, outputs: Path):
    run = record(tracker_at(outputs / "mlflow.db", artifact="curves"), *learned())
    with pytest.raises(ConfigError, match="holds its curves only"):
        say("rerun", run.run_id)


def test_a_store_that_does_not_exist_has_no_status_and_is_not_created(say, outputs: Path):
    with pytest.raises(
        ConfigError, match=r"typo/mlflow\.db: no run has been recorded there yet; outputs=DIR looks there"
    ):
        words.run("store", ["status", f"outputs={outputs}/typo"])
    assert not (outputs / "typo").exists()


def test_the_usage_names_what_belongs_to_each_action(say):
    status, output = say("store", "--help")
    assert status == 0
    for usage in ("status [--check]", "forget RUN_ID ...", "forget --damaged", "compact"):
        assert f"rl-design-space store {usage} [KEY=VALUE ...]\n" in output


def test_the_usage_of_a_comparison_names_its_sides_before_the_flag_that_would_take_them(capsys):
    with pytest.raises(SystemExit):
        figure_words.main("compare", ["--help"])
    assert capsys.readouterr().out.startswith("usage: rl-design-report compare A B [--where KEY=VALUE ...] ")
