"""The top of the page: claims with and without a multiverse."""

from __future__ import annotations

from pathlib import Path

import pandas as pd
import pytest

from rl_design_space.plan.plan import Plan
from rl_design_space.plan.study import Study
from rl_design_space.report.page import Page, Section
from rl_design_space.report.page_claims import page_claims
from tests.points import planning

PAGE = Page(
    title="Short", sections=("fig3", "claims"), verdicts="claims", multiverse="multiverse", ui="http://127.0.0.1:5000"
)
NUMBERS = {"value": 1.2, "ci_low": 1.1, "ci_high": 1.3, "what": "k = 0.03 / best k", "p": 0.01}


@pytest.fixture
def ledger(tmp_path: Path) -> Path:
    rows = [
        {"claim": "fig3-a", "statement": "k is <best>", "verdict": "not reproduced", "study": "fig3", **NUMBERS,
         "later_verdict": "reproduced"},
        {"claim": "s4-a", "statement": "future work", "verdict": "undecided", "study": "none"},
    ]  # fmt: skip
    path = tmp_path / "claims.csv"
    pd.DataFrame(rows).to_csv(path, index=False)
    return path


@pytest.fixture
def multiverse(tmp_path: Path) -> Path:
    claims = [
        {"claim": "fig3-a", "mark": "holds under", "share": 0.4, "choices": "steps_after=30; mean", "within": 0.97,
         "specifications": 1234, "hangs_on": "measure"},
        {"claim": "s4-a", "mark": "cannot be told", "specifications": 0},
    ]  # fmt: skip
    pd.DataFrame(claims).to_csv(tmp_path / "multiverse_claims.csv", index=False)
    curve = {"claim": "fig3-a", "place": [0.0, 0.3, 0.6], "log": [-1, 0, 0.5], "state": ["fails", "unknown", "holds"]}
    pd.DataFrame(curve).to_csv(tmp_path / "multiverse_curve.csv", index=False)
    return tmp_path / "multiverse"


def rendered(ledger: Path, multiverse: Path | None) -> str:
    with planning() as planner:
        study = Study("short", (), planner.composer.config(()), Plan([], ("short",)))
    names = ["fig3", "claims", *(["multiverse"] if multiverse else [])]
    sections = [Section(name, name, "", "") for name in names]
    return PAGE.render(study, sections, page_claims(ledger, multiverse))


def test_a_claim_has_a_mark_its_verdicts_a_number_and_a_picture(ledger: Path, multiverse: Path):
    html = rendered(ledger, multiverse)
    assert "◐</span> holds under steps_after=30 and mean</strong>" in html
    assert "k is &lt;best&gt;" in html
    assert 'as registered: <strong class="bad">not reproduced</strong>' in html
    assert 'later: <strong class="good">reproduced</strong>' in html
    assert "k = 0.03 / best k: 1.2 (1.1 – 1.3)" in html
    assert html.count("<svg") == html.count('role="img"') == 1
    assert 'aria-label="Specification curve of fig3-a: it holds under 40% of 1,234 specifications' in html
    assert "?</span> cannot be told" in html
    assert "make multiverse" not in html


def test_a_page_without_a_multiverse_says_how_to_make_it_and_shows_the_rest(ledger: Path):
    html = rendered(ledger, None)
    assert "<code>make multiverse</code> runs it" in html
    assert "holds under" not in html
    assert "<svg" not in html
    assert 'as registered: <strong class="bad">not reproduced</strong>' in html


@pytest.mark.parametrize(
    ("numbers", "shown"),
    [
        ({"value": 100, "ci_low": 100, "ci_high": float("inf")}, "≥ 100"),
        ({"value": 90, "ci_low": 80, "ci_high": float("inf")}, "90 (≥ 80)"),
        ({}, "1.2 (1.1 – 1.3)"),
    ],
)
def test_never_is_shown_as_a_bound(tmp_path: Path, numbers: dict, shown: str):
    row = {"claim": "a", "statement": "s", "verdict": "undecided", "study": "none", **NUMBERS, **numbers}
    pd.DataFrame([row]).to_csv(tmp_path / "claims.csv", index=False)
    (claim,) = page_claims(tmp_path / "claims.csv", None)
    assert claim.measured == f"k = 0.03 / best k: {shown}"
