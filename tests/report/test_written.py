"""What reports return beside their files: their main numbers, from the values that their tables are made of."""

from __future__ import annotations

import pickle
from pathlib import Path

import pandas as pd
import pytest

from rl_design_space.report import ClaimsLedger, Curves, Heatmap
from rl_design_space.report.base import MAIN, Report
from rl_design_space.report.claims_judged import _LATER_COLUMNS
from rl_design_space.report.markdown import table
from rl_design_space.report.runs import Runs
from rl_design_space.report.style import plt
from rl_design_space.report.written import MainNumbers, Written, numbers_of
from tests.report.readers import LearningReader

FRAMES = {MAIN: pd.DataFrame({"reward": ["many_rewards", "end_reward"], "steps": [1234.56, 7.0]})}
LABELS = {"reward": "Reward", "reward=end_reward": "in the end"}


class Own(Report):
    """A report as its user wrote it before main numbers were returned."""

    parts: tuple = ()

    def frames(self, runs):
        return FRAMES

    def draw(self, frames):
        return plt.figure(figsize=(1, 1))

    def text(self, frames):
        return list(self.parts)


class InSentences(Own):
    def numbers(self, frames):
        return ["reward=end_reward: 7 steps"]


def of(kind: type[Own], *parts: str) -> Own:
    own = kind(title="Mine", labels=LABELS)
    object.__setattr__(own, "parts", parts)
    return own


def test_the_main_numbers_are_the_first_table_of_the_text():
    texts = pd.DataFrame({"reward": ["reward=end_reward", "**x | y**"], "n": [3, 20]})
    own = of(Own, "A sentence.", table(texts), table(FRAMES[MAIN]))
    assert own.main_numbers(FRAMES) == MainNumbers(
        "Mine", header=("Reward", "n"), rows=(("in the end", "3"), ("**x | y**", "20"))
    )


def test_a_text_without_a_table_has_the_main_frame_and_sentences_stand_for_either():
    assert of(Own, "Only this.").main_numbers(FRAMES) == MainNumbers(
        "Mine", header=("Reward", "steps"), rows=(("many_rewards", "1,235"), ("end_reward", "7"))
    )
    assert of(InSentences, table(FRAMES[MAIN])).main_numbers(FRAMES) == MainNumbers("Mine", ("in the end: 7 steps",))
    assert of(Own, "Only this.").main_numbers({"_other": FRAMES[MAIN]}) == MainNumbers("Mine")


def test_writing_returns_paths_with_the_main_numbers_and_a_list_of_paths_has_none(tmp_path: Path):
    own = of(InSentences, "Only this.")
    paths = own.write_runs(Runs([], LearningReader([])), tmp_path / "own")
    assert [path.suffix for path in paths] == [".png", ".svg", ".csv", ".md"]
    assert paths.numbers == (own.main_numbers(FRAMES),)
    plain = [tmp_path / "a.md"]
    both = Written.joined([paths, plain])
    assert both == [*paths, *plain]
    assert both.numbers == paths.numbers
    assert numbers_of(plain) == ()
    other = pickle.loads(pickle.dumps(both))  # as it comes from a process that writes a part of a page
    assert (other, other.numbers) == (both, both.numbers)


def test_figures_have_their_main_numbers():
    cells = pd.DataFrame({"k": [1, 2, 3], "d": ["a_b"] * 3, "value": [30.0, 10.0, float("nan")]})
    assert Heatmap(rows="k", cols="d").main_numbers({MAIN: cells}).lines == (
        "Least: 10 with k=2 d=a_b",
        "Most: 30 with k=1 d=a_b",
    )
    line = {"line": "k=1", "trial": [0, 1], "mean": [9.0, 2.0], "ci_low": [8.0, 1.0], "ci_high": [10.0, 3.0], "runs": 2}
    curves = Curves(by="k").main_numbers({MAIN: pd.DataFrame(line)})
    assert curves.header == ("line", "steps/mean at the last trial", "95 % interval", "runs")
    assert curves.rows == (("k=1", "2", "1 – 3", "2"),)


@pytest.mark.parametrize("has_later", [False, True])
def test_a_ledger_counts_its_verdicts_and_lists_them(has_later: bool):
    later = dict.fromkeys(_LATER_COLUMNS, "undecided") if has_later else {}
    claims = pd.DataFrame([{"claim": "t4-a", "statement": "it grows", "verdict": "reproduced", **later}])
    ledger = ClaimsLedger(title="Claims", common={}, claims={})
    numbers = ledger.main_numbers({MAIN: claims})
    assert numbers.lines[0] == "1 claims: 1 reproduced, 0 not reproduced, 0 undecided"
    assert len(numbers.lines) == 1 + has_later
    assert numbers.rows == (("t4-a", "reproduced", *(["undecided"] if has_later else []), "it grows"),)
