"""Figures of any runs: their numbers are those of the simulations, and what is not known is left out."""

from __future__ import annotations

import csv
import re
import sqlite3
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest
from PIL import Image

import rl_design_space as rds
from rl_design_space.analysis.statistics import percentile_interval, resample_weights
from rl_design_space.commands import figure_words as command
from rl_design_space.config.build import construct
from rl_design_space.errors import ConfigError
from rl_design_space.learning import simulate
from rl_design_space.learning.measures import MEASURES, measure
from rl_design_space.report import Compare, Curves, Heatmap, Sensitivity
from rl_design_space.report.base import MAIN
from rl_design_space.report.runs import Runs
from tests.points import planned_point
from tests.tracking.stores import copy_database, options, record, tracker_at

SIZE = ("task.periods=6", "task.trials=5", "world.size=4", "exploration=linear")
#: Two representations at three k, one of them missing; and a second seed of one.
OVERRIDES = [
    (f"representation={name}", f"exploration.k={k}")
    for name in ("ad_hoc", "direction")
    for k in (0.02, 0.05, 0.1)
    if (name, k) != ("direction", 0.05)
]
LEARNED = {overrides: simulate(planned_point([*SIZE, *overrides]).point) for overrides in OVERRIDES}


@pytest.fixture(scope="module")
def outputs(empty_database: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("generic")
    copy_database(empty_database, folder / "mlflow.db")
    tracker = tracker_at(folder / "mlflow.db")
    for overrides, curves in LEARNED.items():
        record(tracker, replace(planned_point([*SIZE, *overrides]), studies=("mine",)), curves)
    return folder


@pytest.fixture(scope="module")
def runs(outputs: Path) -> Runs:
    reader = options(outputs / "mlflow.db").reader()
    return Runs.of_frame(reader.frame(), reader, "the command")


def test_a_heatmap_holds_what_simulations_give(runs: Runs):
    frame = Heatmap(rows="representation", cols=["exploration.k"]).frames(runs)[MAIN]
    assert len(frame) == 6
    for cell in frame.to_dict("records"):
        key = (f"representation={cell['representation']}", f"exploration.k={cell['exploration.k']}")
        if key in LEARNED:
            assert cell["value"] == LEARNED[key].total_steps.mean()
            assert cell["low"] < cell["value"] < cell["high"]
        else:
            assert np.isnan(cell["value"])
            assert cell["runs"] == 0


NAMED = ("steps_after=2", "near_share=3,statistic=cvar=5", "total_steps_scaled,statistic=median", "gap_closed=0.01")


@pytest.mark.parametrize("name", [*MEASURES, *NAMED])
def test_every_measure_can_be_the_value_of_a_cell(runs: Runs, name: str):
    frame = Heatmap(rows="representation", cols="exploration.k", value=name).frames(runs)[MAIN]
    equal = np.full((1, 6), 1 / 6)
    for cell in frame.dropna(subset="value").to_dict("records"):
        curves = LEARNED[f"representation={cell['representation']}", f"exploration.k={cell['exploration.k']}"]
        assert cell["value"] == pytest.approx(measure(name).samples(curves, equal)[0])
        assert cell["low"] <= cell["value"] <= cell["high"]
    assert frame["value"].notna().sum() == len(LEARNED)


def test_a_measure_may_be_a_mapping_and_a_wrong_one_is_named():
    figure = construct(Heatmap, {"rows": "a", "cols": "b", "value": {"steps_after": 2, "statistic": "median"}})
    assert figure.heading == "steps_after=2,statistic=median by a and b"
    for kind, words in ((Heatmap, {"rows": "a", "cols": "b"}), (Sensitivity, {"parameter": "a"})):
        assert construct(kind, {**words, "value": "total_steps_sem"}).value == "total_steps_sem"
        with pytest.raises(ConfigError, match=r"^value: total: no such measure; did you mean total_steps"):
            construct(kind, {**words, "value": "total"})
        with pytest.raises(ConfigError, match=r"^value: steps_after=-2: should be a trial"):
            construct(kind, {**words, "value": "steps_after=-2"})


def test_a_trial_that_is_never_reached_is_shown_as_a_bound(runs: Runs):
    figure = Heatmap(rows="representation", cols="exploration.k", value="trials_to=1.1")
    frames = figure.frames(runs)
    known = frames[MAIN].dropna(subset="value")
    assert known["value"].tolist() == [5] * len(LEARNED)
    assert set(known["bounds"]) == {"value ≥, low ≥, high ≥"}
    assert any("Least: ≥ 5 with" in part for part in figure.text(frames))
    axis = figure.draw(frames).axes[0]
    assert "≥ 5" in {text.get_text() for text in axis.texts}
    plt.close(axis.figure)
    sensitivity = Sensitivity(parameter="exploration.k", value="trials_to=1.1")
    rows, *_, note = sensitivity.text(sensitivity.frames(runs))
    assert "≥ 5 (≥ 5)" in rows
    assert re.sub(" +", " ", rows).rstrip().endswith("| – |")
    assert "no ratio is formed" in note.lower()


def test_measures_of_curves_and_medians_are_compared_under_the_same_weights(runs: Runs):
    sides = {"a": "representation=ad_hoc", "b": "representation=direction"}
    for name in ("roughness", "total_steps,statistic=median"):
        rows = Compare(**sides, value=name).frames(runs)[MAIN].to_dict("records")
        for row, k in zip(rows[:2], (0.02, 0.1), strict=True):
            one, other = (LEARNED[side, f"exploration.k={k}"] for side in sides.values())
            a, b = (measure(name).samples(each, np.full((1, 6), 1 / 6))[0] for each in (one, other))
            assert (row["a"], row["b"], row["difference"]) == pytest.approx((a, b, b - a))
            weights = resample_weights(6)
            samples = measure(name).samples(other, weights) - measure(name).samples(one, weights)
            assert (row["low"], row["high"]) == pytest.approx(tuple(percentile_interval(samples)))
    figure = Compare(**sides, value="trials_to=1.1")
    frames = figure.frames(runs)
    assert frames[MAIN]["difference"].isna().all()  # never on both sides: nothing is known
    assert frames[MAIN]["bounds"][0] == "a ≥, b ≥"
    plt.close(figure.draw(frames))


def test_runs_that_differ_in_more_than_the_seed_are_averaged_on_demand_only(runs: Runs):
    with pytest.raises(ConfigError, match=r"exploration\.k: \d runs of one cell .* differ in this; .*--mean"):
        Heatmap(rows="representation", cols="world.size").frames(runs)[MAIN]
    frame = Heatmap(rows="representation", cols="world.size", mean=True).frames(runs)[MAIN]
    expected = np.mean([curves.total_steps.mean() for key, curves in LEARNED.items() if "ad_hoc" in key[0]])
    assert frame.set_index("representation").loc["ad_hoc", "value"] == pytest.approx(expected)


def test_curves_are_those_of_the_simulations(runs: Runs):
    frame = Curves(by="representation,exploration.k").frames(runs)[MAIN]
    for key, curves in LEARNED.items():
        line = frame[frame["line"] == " ".join(key)]
        assert line["mean"].tolist() == curves.curves["steps/mean"].tolist()
        assert (line["ci_low"] <= line["mean"]).all()


def test_a_curve_that_is_a_mean_over_periods_has_a_band(runs: Runs):
    for name in ("steps/over_optimum", "success_rate"):
        frame = Curves(by="representation,exploration.k", curve=name).frames(runs)[MAIN]
        assert frame["ci_low"].notna().all()
        for key, curves in LEARNED.items():
            line = frame[frame["line"] == " ".join(key)]
            assert line["mean"].tolist() == curves.curves[name].tolist()
            assert (line["ci_low"] <= line["mean"]).all()


def test_a_curve_without_known_periods_has_no_band(runs: Runs):
    frame = Curves(by="exploration.k,representation", curve="steps/median").frames(runs)[MAIN]
    assert frame["ci_low"].isna().all()
    assert frame["mean"].notna().all()


def test_sensitivity_has_a_line_for_each_of_the_other_choices(runs: Runs):
    frame = Sensitivity(parameter="exploration.k", value="failed_trials").frames(runs)[MAIN]
    assert frame.groupby("line").size().to_dict() == {"representation=ad_hoc": 3, "representation=direction": 2}
    for row in frame.to_dict("records"):
        curves = LEARNED[row["line"], f"exploration.k={row['exploration.k']}"]
        assert row["value"] == pytest.approx(1 - curves.success.mean())


def test_many_lines_are_drawn_with_their_median():
    figure = Sensitivity(parameter="k", scale="linear")
    rows = [
        (f"line {i}", k, float(10 * i + k), 0.0, 0.0, 1) for i in range(9) for k in ((3, 2, 1) if i % 2 else (1, 2))
    ]
    frame = pd.DataFrame(rows, columns=["line", "k", "value", "low", "high", "runs"])
    (axis,) = figure.draw({MAIN: frame}).axes
    (median,) = (line for line in axis.lines if line.get_color() == "black")
    assert median.get_xdata().tolist() == [1, 2, 3]
    assert median.get_ydata().tolist() == frame.groupby("k")["value"].median().tolist()
    assert [text.get_text() for text in axis.get_legend().get_texts()][:3] == [
        "80 % of 9 lines", "half of them", "their median",
    ]  # fmt: skip
    plt.close(axis.figure)


def test_a_comparison_is_paired_by_period(runs: Runs):
    frame = Compare(a="representation=ad_hoc", b="representation=direction").frames(runs)[MAIN]
    assert frame["pair"].tolist() == ["exploration.k=0.02", "exploration.k=0.1", "all pairs"]
    for row, k in zip(frame.to_dict("records")[:2], (0.02, 0.1), strict=True):
        one, other = (LEARNED[f"representation={name}", f"exploration.k={k}"] for name in ("ad_hoc", "direction"))
        assert row["difference"] == pytest.approx((other.total_steps - one.total_steps).mean())
        assert row["periods"] == 6
    assert frame["difference"].iloc[2] == pytest.approx(frame["difference"][:2].mean())


def test_lines_are_named_by_what_tells_them_apart_from_each_other(outputs: Path):
    reader = options(outputs / "mlflow.db").reader()
    frame = reader.frame()
    lone = frame[frame["representation"] == "ad_hoc"].index[0]
    frame.loc[lone, "world.size"] = 7  # a line of this run alone would be none
    found = Sensitivity(parameter="exploration.k").frames(Runs.of_frame(frame, reader, "the command"))
    lines = found[MAIN].groupby("line").size().to_dict()
    assert lines == {"representation=ad_hoc": 2, "representation=direction": 2}


@pytest.mark.parametrize(
    ("figure", "message"),
    [
        (
            Heatmap(rows="representatio", cols="exploration.k"),
            r"representatio: no such parameter .* mean representation",
        ),
        (Curves(by="representation,exploration.k", curve="steps/max"), r"steps/max: no such learning curve"),
        (Sensitivity(parameter="reward"), "reward: no two of these runs differ in it"),
        (
            Compare(a="representation=ad_hoc", b="representation=distance"),
            r"representation=distance: no run has this value; there is ad_hoc, direction",
        ),
        (
            Compare(a="representation=direction", b="representation=direction"),
            "representation=direction, representation=direction: both sides are the same",
        ),
        (Compare(a="ad_hoc", b="direction"), "ad_hoc: should be values of parameters, such as representation=ad_hoc"),
    ],
)
def test_a_figure_that_cannot_be_drawn_is_refused(figure, message: str, runs: Runs):
    with pytest.raises(ConfigError, match=message):
        figure.frames(runs)


WORDS = {
    "heatmap": ("--rows", "representation", "--cols", "exploration.k"),
    "curves": ("--by", "representation,exploration.k"),
    "sensitivity": ("exploration.k",),
    "compare": ("representation=ad_hoc", "representation=direction"),
}


@pytest.mark.parametrize("word", WORDS)
def test_a_command_writes_a_picture_with_its_numbers(word: str, outputs: Path):
    paths = command.main(
        word, [*WORDS[word], "--study", "mine", f"outputs={outputs}", f"tracking.spool={outputs}/spool"]
    )
    assert [path.suffix for path in paths] == [".png", ".svg", ".csv", ".md"]
    assert {path.parent for path in paths} == {outputs / "report"}
    with Image.open(paths[0]) as picture:
        assert picture.width > 500
        assert len(picture.convert("RGB").getcolors(10**6)) > 20
    with paths[2].open(encoding="utf-8", newline="") as file:
        assert len(list(csv.DictReader(file))) > 2
    text = paths[3].read_text(encoding="utf-8")
    assert f"Made by `rl-design-report {word} " in text
    # One of them has no partner.
    assert f" from {'4 of 5 runs' if word == 'compare' else '5 runs'}, 6 periods a point." in text
    assert ("Hatched: 1 of 6 cells" in text) == (word == "heatmap")


def test_a_name_for_the_files_can_be_chosen(outputs: Path):
    paths = command.main("sensitivity", ["exploration.k", "--name", "k", f"outputs={outputs}"])
    assert {path.stem for path in paths} == {"k"}
    with pytest.raises(ConfigError, match=r"--name=\.\./k: should be a name without \.\."):
        command.main("sensitivity", ["exploration.k", "--name", "../k", f"outputs={outputs}"])


def test_names_with_a_space_between_them_are_told_of_the_comma():
    with pytest.raises(ConfigError, match=r"as in --by representation,exploration\.k$"):
        command.main("curves", ["--by", "representation", "exploration.k"])
    with pytest.raises(ConfigError, match=r"exploration\.k: not an override; should be KEY=VALUE"):
        command.main("curves", ["--by", "representation", "--mean", "exploration.k"])


def test_a_selection_without_runs_is_refused(outputs: Path):
    with pytest.raises(ConfigError, match="no run was selected"):
        command.main("sensitivity", ["exploration.k", "--filter", "metrics.total_steps < 0", f"outputs={outputs}"])
    with pytest.raises(ConfigError, match=r"study among these runs.*there is mine"):
        command.main("sensitivity", ["exploration.k", "--study", "table4", f"outputs={outputs}"])


def test_runs_are_selected_in_the_words_of_the_command_line(outputs: Path, capsys: pytest.CaptureFixture[str]):
    # In one store: settings after the values are settings, and values are in the grammar of sweeps.
    words = ["--where", "exploration.k=0.02,0.10", "representation=ad_hoc", f"outputs={outputs}"]
    paths = command.main("sensitivity", ["exploration.k", "--name", "where", *words])
    assert pd.read_csv(paths[2])["exploration.k"].tolist() == [0.02, 0.1]
    for wrong, message in {
        "representation=ad_hok": r"representation=ad_hok: no run has this value; there is ad_hoc, direction",
        "representatio=ad_hoc": r"representatio: no such parameter of these runs; did you mean representation\?",
        "ad_hoc": "--where ad_hoc: should be KEY=VALUE, such as exploration=linear",
        "study=mine": "study=mine: not a parameter of runs; --study mine selects the runs of a study",
        "study=mine,table4": "; --study mine selects",
        "plan=true": r"plan=true: not a setting of this command, which takes outputs=…, threads=…, tracking=…",
        "objective=total_steps": "objective=total_steps: not a setting of this command",
        "fingerprint=abc": "fingerprint: no such parameter of these runs",
    }.items():
        with pytest.raises(ConfigError, match=message):
            command.main("sensitivity", ["exploration.k", "--where", wrong, f"outputs={outputs}"])
    missing = ["--where", "representation=direction", "exploration.k=0.05", f"outputs={outputs}"]
    with pytest.raises(ConfigError, match="no run was selected"):
        command.main("sensitivity", ["exploration.k", *missing])
    assert "left out" not in capsys.readouterr().err


def test_runs_of_earlier_code_are_left_out_everywhere_with_a_note(
    outputs: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    copy_database(outputs / "mlflow.db", tmp_path / "mlflow.db")
    with closing(sqlite3.connect(tmp_path / "mlflow.db")) as database:
        query = "insert into params (key, value, run_uuid) select 'representation.source', ?, run_uuid from runs where "
        database.execute(f"{query} name like '%direction%k=0.02%'", ["version 1"])
        database.execute(f"{query} name like '%direction%k=0.1 %'", ["version 2"])
        database.commit()
    note = "left out: 1 of 5 runs, recorded with earlier code of representation=direction"
    store = {"outputs": str(tmp_path)}
    with pytest.warns(UserWarning, match=f"{note}; outdated=True includes them"):
        assert len(rds.load_runs(**store)) == 4
    assert len(rds.load_runs(**store, outdated=True)) == 5
    assert len(rds.load_runs(**store, filter="params.`representation.source` = 'version 1'")) == 1
    assert len(rds.load_runs(**store, where={"representation.source": "version 1"})) == 1
    paths = command.main("sensitivity", ["exploration.k", f"outputs={tmp_path}"])
    assert f"{note}; to include them, name their code" in capsys.readouterr().err
    assert f"{note.capitalize()}." in paths[3].read_text(encoding="utf-8")
    command.main("curves", ["--by", "representation.source,representation,exploration.k", f"outputs={tmp_path}"])
    assert "left out" not in capsys.readouterr().err


def test_a_study_carries_its_own_figures(outputs: Path, tmp_path: Path):
    from rl_design_space.commands.report import write_report
    from rl_design_space.config.user_config import used

    study = tmp_path / "conf" / "study" / "own.yaml"
    study.parent.mkdir(parents=True)
    study.write_text(
        "blocks:\n  a: {representation: 'ad_hoc,direction', exploration: linear, exploration.k: '0.02,0.05,0.1',\n"
        "      task.periods: 6, task.trials: 5, world.size: 4}\n"
        "report:\n  _target_: rl_design_space.report.Figures\n  figures:\n"
        "    map: {_target_: rl_design_space.report.Heatmap, rows: representation, cols: exploration.k}\n"
        "    slope: {_target_: rl_design_space.report.Sensitivity, parameter: exploration.k}\n",
        encoding="utf-8",
    )
    with used(tmp_path / "conf"):
        paths = write_report("own", [f"outputs={outputs}"])
    assert {path.name for path in paths if path.suffix == ".png"} == {"own-map.png", "own-slope.png"}
    text = next(path for path in paths if path.name == "own-map.md").read_text(encoding="utf-8")
    assert re.search(r"\*\*Missing: 1 of 6 points\*\*", text)
    assert "Hatched: 1 of 6 cells" in text
