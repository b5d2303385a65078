"""How reports look: sizes, files, labels and orders are those that were asked for, and nonsense is refused."""

from __future__ import annotations

import re
from dataclasses import fields
from pathlib import Path

import matplotlib.pyplot as plt
import pandas as pd
import pytest
from matplotlib.text import Text

from rl_design_space import report
from rl_design_space.commands import figure_words
from rl_design_space.commands.figure_arguments import WORDS, flags, look_names
from rl_design_space.commands.look_arguments import NAMES, flag_of, take_look, unused_labels
from rl_design_space.commands.report import _parser
from rl_design_space.config import user_config
from rl_design_space.config.build import construct
from rl_design_space.errors import ConfigError
from rl_design_space.plan.planner import plan_point
from rl_design_space.plan.study_values import study_values
from rl_design_space.report import Compare, Curves, Figures, Heatmap, Interactions
from rl_design_space.report.base import MAIN, Report
from rl_design_space.report.fitting import fit
from rl_design_space.report.latex import latex_table
from rl_design_space.report.look import Look
from rl_design_space.report.markdown import Table, table
from rl_design_space.report.ordering import Ordering
from rl_design_space.report.points import Point
from rl_design_space.report.runs import Runs
from rl_design_space.report.stage_marks import STAGES
from rl_design_space.report.words import Words
from tests.report.readers import LearningReader

LABELS = {
    "exploration.k": "decay k",
    "representation": "State representation",
    "representation=ad_hoc": "Ad hoc",
    "total_steps": "Total steps",
    "reward": "Reward",
}


def cells(*names: str) -> pd.DataFrame:
    rows = [(name, k, 100.0 * k + place, 90.0, 110.0, 1) for place, name in enumerate(names) for k in (1, 2)]
    return pd.DataFrame(rows, columns=["representation", "exploration.k", "value", "low", "high", "runs"])


class Made(Heatmap):
    """A heatmap of made-up cells."""

    def frames(self, runs: Runs):
        return {MAIN: cells("ad_hoc", "direction")}


def written(folder: Path, **look) -> dict[str, Path]:
    made = Made(rows="representation", cols="exploration.k", **look)
    return {path.suffix: path for path in made.write_runs(Runs([], LearningReader([])), folder / "made")}


def test_a_pdf_has_the_size_that_was_asked_for_and_embedded_fonts(tmp_path: Path):
    files = written(tmp_path, width="column", height=3, format="pdf,latex", labels=LABELS)
    pdf = files[".pdf"].read_bytes()
    assert pdf.startswith(b"%PDF-")
    assert b"/MediaBox [ 0 0 252 216 ]" in pdf
    assert b"/CIDFontType2" in pdf  # Type 42
    assert b"/Type3" not in pdf
    assert re.search(rb'<svg[^>]* width="252pt" height="216pt"', files[".svg"].read_bytes())
    text = files[".tex"].read_text()
    assert r"State representation / decay k & 1 & 2 \\" in text
    assert r"Ad hoc & 100 & 200 \\" in text
    assert files[".csv"].read_text().startswith("representation,exploration.k,")  # numbers keep the names
    assert "Least: 100 with Ad hoc, decay k=1." in files[".md"].read_text()
    again = written(tmp_path, width="column", height=3, format=["pdf", "latex"], labels=LABELS)
    assert again[".pdf"].read_bytes() == pdf


def test_options_left_out_change_nothing(tmp_path: Path):
    (tmp_path / "other").mkdir()
    usual, other = written(tmp_path), written(tmp_path / "other", labels={}, order={}, format=[])
    assert usual.keys() == {".png", ".svg", ".csv", ".md"}
    assert all(usual[suffix].read_bytes() == other[suffix].read_bytes() for suffix in usual)


def texts(figure) -> list[str]:
    figure.draw_without_rendering()
    return [text.get_text() for text in figure.findobj(Text) if isinstance(text, Text) and text.get_text()]


def test_text_is_as_large_as_asked_for():
    figure, axis = plt.subplots(figsize=(4, 3), layout="constrained")
    axis.plot([0, 1], [0, 1], label="line")
    axis.set_title("a title", fontsize=11)
    axis.legend(fontsize=8)
    axis.set_xlabel("x", fontsize=9)
    axis.tick_params(labelsize=10)
    fit(figure, None, None, 18)
    figure.draw_without_rendering()
    sizes = [
        axis.title.get_fontsize(),
        axis.get_legend().get_texts()[0].get_fontsize(),
        axis.xaxis.label.get_fontsize(),
    ]
    assert sizes == [22, 16, 18]
    assert {tick.get_fontsize() for tick in axis.get_xticklabels()} == {20}
    plt.close(figure)


@pytest.mark.parametrize(
    ("size", "message"),
    [
        ((None, None, 40), "font_size=40: leaves no room for the data .*; should be less; 9 is usual"),
        ((1, None, None), "width=1: leaves no room for the data .*; should be more; its own width is 7.5 inches"),
        ((None, 1, None), "height=1: leaves no room for the data .*; should be more; its own height is 4 inches"),
    ],
)
def test_a_size_that_leaves_no_room_for_the_data_is_refused(size: tuple[float | None, ...], message: str):
    figure, axis = plt.subplots(figsize=(7.5, 4), layout="constrained")
    axis.set(title="\n".join(["T"] * 5), ylabel="y", xlabel="x")
    axis.set_yticks([0, 1], ["a long name of a design", "another long name"])
    with pytest.raises(ConfigError, match=message):
        fit(figure, *size)
    plt.close(figure)


KINDS = [getattr(report, name) for name in report.__all__ if issubclass(getattr(report, name), Report)]
BAD = [
    ("width", "wide", "should be column (3.5) or page (7.16), or inches from 1 to 50"),
    ("width", 0.2, "or inches from 1 to 50"),
    ("height", "nan", "should be inches from 1 to 50"),
    ("font_size", 1000, "should be points from 3 to 40"),
    ("format", "docx", "there is no format docx"),
    ("colour_map", "viridi", "did you mean viridis?"),
    ("scale", "sqrt", "should be linear or log"),
    ("labels", "k", "should be a mapping of names to texts"),
    ("labels.k", "", "should not be empty"),
]


@pytest.mark.parametrize(("name", "value", "expected"), BAD)
def test_nonsense_is_refused_by_its_name(name: str, value, expected: str):
    option, _, key = name.partition(".")
    with pytest.raises(ConfigError) as raised:
        construct(Heatmap, {"rows": "a", "cols": "b", option: {key: value} if key else value}, "study.report")
    assert f"{name}={value}" in str(raised.value)
    assert expected in str(raised.value)
    assert "\n" not in str(raised.value)


def test_an_option_without_effect_is_refused():
    with pytest.raises(ConfigError, match=r"order=.*Best has no order to choose"):
        construct(report.Best, {"order": {"reward": ["a"]}})
    with pytest.raises(ConfigError, match="scale=log: should be linear or ratio"):
        construct(Compare, {"a": "x=1", "b": "x=2", "scale": "log"})
    assert Interactions(scale="log_steps").scale == "log_steps"  # a scale of its own


def test_every_report_takes_every_option_on_the_command_line_and_in_yaml():
    names = {field.name for field in fields(Look)}
    assert set(NAMES) == names
    for kind in KINDS:
        assert names <= {field.name for field in fields(kind)}
    for word in WORDS:
        assert {flag_of(name) for name in look_names(word)} <= set(flags(word))
        assert "--title" in flags(word)
    given = ["table4", "--width", "page", "--format", "pdf", "--labels", "reward=Reward=1", "--title", "T", "outputs=x"]
    chosen = _parser(given).parse_intermixed_args(given)
    look, settings = take_look(chosen)
    assert look == {"width": "page", "format": ["pdf"], "labels": {"reward=Reward": "1"}}
    assert (chosen.overrides, settings) == (["outputs=x"], [])


@pytest.mark.parametrize(
    ("typed", "message"),
    [
        (["--width", "wide"], "--width=wide: should be column"),
        (["--labels", "k"], "--labels k: should be NAME=TEXT"),
        (["--labels", "k="], "--labels k=: has no text; should be NAME=TEXT"),
        (["--labels", "k=a", "--labels", "k=b"], "--labels k=a k=b: should be one text for a name"),
        (["--where", "k=1", "l=2", "k=3"], "--where k=1 k=3: should be one, such as --where k=1,3"),
        (["--by", "msa"], "--by reward, --by msa: should be one, such as --by reward,msa"),
        (["--width", "3", "--width", "4"], "--width 3, --width 4: should be given once"),
        (["--labels", "there_is_no.yaml"], "there_is_no.yaml: cannot be read"),
        (["--order", "k"], "--order k: should be KEY=VALUE"),
        (["--font-size", "huge"], "--font-size=huge: should be points"),
    ],
)
def test_a_message_names_the_flag(typed: list[str], message: str):
    with pytest.raises(ConfigError) as raised:
        figure_words.main("curves", ["--by", "reward", *typed])
    assert str(raised.value).startswith(message)


def test_a_label_of_a_name_that_no_run_has_is_told():
    runs = pd.DataFrame({"exploration.k": [0.1, 0.2], "representation": ["ad_hoc", "direction"]})
    given = ["exploration.k=decay", "representation=ad_hoc=Ad hoc", "steps_after=2=late", "steps/mean=steps"]
    assert list(unused_labels([*given, "exploration.k=0.1=little", "labels.yaml", "outputs=x"], runs)) == []
    name, value = unused_labels(["exploration.kk=decay", "representation=ad_hok=Ad hoc"], runs)
    assert name.startswith("unused: --labels exploration.kk: no such parameter or measure of these runs; did you mean")
    assert value == "unused: --labels representation=ad_hok: no run has this value (there is ad_hoc, direction)"


def test_labels_are_those_of_the_config_folder_of_the_study_and_of_the_command(tmp_path: Path):
    (tmp_path / "labels.yaml").write_text("reward: Reward\nexploration.k: decay\n")
    with user_config.used(tmp_path):
        curves = Curves(by="reward", labels={"exploration.k": "k"}).looking({"labels": {"steps/mean": "Steps"}})
        assert curves.words.labels == {"reward": "Reward", "exploration.k": "k", "steps/mean": "Steps"}
        (tmp_path / "labels.yaml").write_text("reward: [1]\n")
        with pytest.raises(ConfigError, match=r"labels\.yaml\.reward=\[1\]: should be a text"):
            _ = Curves(by="reward").words


def test_figures_pass_the_look_on():
    figures = Figures(figures={"a": Curves(by="reward")}).looking({"width": "page"})
    assert figures.figures["a"].looking(figures.look).width == 7.16


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("representation=ad_hoc exploration.k=0.02", "Ad hoc, decay k=0.02"),
        ("1  representation=ad_hoc msa=none", "1  Ad hoc, msa=none"),
        ("representation × reward", "State representation × Reward"),
        ("difference of total_steps, no reward", "difference of Total steps, no reward"),
        ("representation.goals=all exploration.k2=3", "representation.goals=all exploration.k2=3"),
        ("representation=ad_hoc2", "State representation=ad_hoc2"),
        ("with representation=b exploration.k=1.", "with State representation=b, decay k=1."),
    ],
)
def test_names_are_labelled_where_they_are_names(text: str, expected: str):
    assert Words(LABELS)(text) == expected
    assert Words({})(text) == text


def test_commands_in_a_text_keep_their_names():
    assert Words(LABELS).paragraph("exploration.k: `--by exploration.k`") == "decay k: `--by exploration.k`"
    assert Words(LABELS).heading("total_steps by reward") == "Total steps by Reward"


def test_labels_are_in_ticks_and_legends_of_a_picture():
    frame = pd.DataFrame({"line": ["representation=ad_hoc"] * 3, "trial": range(3), "mean": 5.0, "runs": 1})
    frame["ci_low"] = frame["ci_high"] = 5.0
    curves = Curves(by="representation", labels=LABELS)
    figure = curves.draw({MAIN: frame, STAGES: pd.DataFrame(columns=["line", "begin"])})
    curves.words.write_into(figure, {curves.heading: "The heading"})
    assert {"Ad hoc", "The heading"} <= set(texts(figure))
    plt.close(figure)
    pair = {"pair": "representation × reward", "value": "reward=b", "reference": "reward=a", "designs": 2}
    numbers = dict.fromkeys(["difference", "low", "high", "interaction", "interaction_low", "interaction_high"], 0.1)
    rows = pd.DataFrame([{**pair, **numbers, "at": f"representation={name}"} for name in ("ad_hoc", "direction")])
    interactions = Interactions(labels=LABELS)
    figure = interactions.draw({MAIN: rows})
    interactions.words.write_into(figure, {})
    assert {"Ad hoc", "direction", "State representation", "Reward=b"} <= set(texts(figure))
    plt.close(figure)


def test_values_are_in_the_order_of_the_study():
    values = {"reward": ["b", "a", "b"], "k": [1, 3, 2], "l": [3, 2, 1], "mixed": [None, "z", 1]}
    ordering = Ordering.of_study(values)
    assert sorted("abc", key=lambda value: ordering.key("reward", value)) == ["b", "a", "c"]
    assert sorted([1, 2, 3], key=lambda value: ordering.key("k", value)) == [1, 2, 3]  # blocks may each hold some
    assert sorted([1, 2, 3], key=lambda value: ordering.key("l", value)) == [3, 2, 1]
    assert sorted([1, None, "z"], key=lambda value: ordering.key("mixed", value)) == ["z", 1, None]
    assert study_values("table3")["representation"][:3] == ["ad_hoc", "distance", "direction"]
    assert study_values("there_is_none") == {}


SIZE = ("task.periods=6", "task.trials=5", "world.size=4", "exploration=linear")


def test_rows_are_in_the_order_that_was_asked_for():
    planned = [plan_point([*SIZE, f"representation={name}"]) for name in ("distance", "ad_hoc", "direction")]
    reader = LearningReader([])
    runs = Runs([Point.planned_with(each, None) for each in planned], reader)
    assert list(runs.grouped(["representation"])) == [("ad_hoc",), ("direction",), ("distance",)]
    ordered = runs.ordered({"representation": ["direction", "distance"]})
    assert list(ordered.grouped(["representation"])) == [("direction",), ("distance",), ("ad_hoc",)]
    with pytest.raises(ConfigError, match=r"order\.representation=none: no run has this value .*ad_hoc, direction"):
        runs.ordered({"representation": ["none"]})
    with pytest.raises(ConfigError, match=r"order\.reprsentation: no such parameter"):
        runs.ordered({"reprsentation": ["none"]})


def test_a_table_is_escaped_for_latex():
    frame = pd.DataFrame({"a_b": ["50 %", "[x] & ≥ 3"], "n": ["1", "2,000"], "c": ["`rl --x`", "**b**"]})
    lines = latex_table(frame, ["made\nby"]).splitlines()
    assert lines[0] == "% made by"
    assert lines[1] == r"\begin{tabular}{lrl}"
    assert lines[3] == r"a\_b & n & c \\"
    assert lines[5] == r"50 \% & 1 & \texttt{rl --x} \\"
    assert lines[6] == r"{[}x{]} \& $\geq$ 3 & 2,000 & \textbf{b} \\"
    made = table(frame)
    assert isinstance(made, Table)
    assert made.frame is frame
