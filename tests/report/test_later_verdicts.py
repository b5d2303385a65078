"""Verdicts that came later: beside the registered ones, judged together, with the paper's own numbers admitted."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import pandas as pd
import pytest
import yaml

from rl_design_space._paths import CONF
from rl_design_space.analysis.parts import Part
from rl_design_space.config.build import build
from rl_design_space.errors import ConfigError
from rl_design_space.plan.plan import Plan
from rl_design_space.plan.study import Study, plan_overrides
from rl_design_space.report import ClaimsLedger
from rl_design_space.report.claims_judged import claims_frame
from rl_design_space.report.runs import Runs
from tests.points import planning
from tests.report.readers import LearningReader, unpadded

ROOT = Path(__file__).parents[2]
PARTS = "rl_design_space.analysis.parts"
SWEEP = ["task.periods=30", "task.trials=8", "task.goals=1", "exploration=linear", "world.size=4,6,8"]


@pytest.fixture(scope="module")
def study() -> Study:
    with planning() as planner:
        return Study("mine", (), planner.composer.config(()), plan_overrides(SWEEP, planner))


def ratio(low: float, **more: object) -> dict:
    sizes = {"point": {"world.size": 8}, "to": {"world.size": 4}}
    return {"_target_": f"{PARTS}.Ratio", "what": "8 / 4", "measure": "total_steps", "low": low, **sizes, **more}


def best(size: int) -> dict:
    return {
        "_target_": f"{PARTS}.WithinOfAll", "what": f"size {size}", "measure": "total_steps", "high": 1.05,
        "parameter": "world.size", "expected": size, "among": {"exploration": "linear"},
    }  # fmt: skip


def ledger(**claims: dict) -> ClaimsLedger:
    nodes = {name: {"statement": f"says {name}", "study": "mine", **claim} for name, claim in claims.items()}
    values = {"title": "Claims", "common": {"exploration": "linear"}, "claims": nodes}
    return build("study.report", {"_target_": "rl_design_space.report.ClaimsLedger", **values})


def either(*parts: dict) -> dict:
    return {"_target_": f"{PARTS}.AnyOf", "what": "either", "parts": list(parts)}


def test_later_verdicts_stand_beside_the_registered_ones(study: Study, tmp_path: Path):
    mine = ledger(
        larger={"parts": [ratio(50.0)], "later": [either(ratio(50.0), ratio(1.5, what="plainly"))]},
        smallest={"parts": [ratio(1.5)], "later": [best(4)]},
        same={"parts": [ratio(1.5)]},
        carried={"parts": [ratio(1.5)], "later": [], "awaits": "Q-matrices that are carried"},
    )
    paths = mine.write(study, LearningReader(study.plan), tmp_path)
    assert {path.name for path in paths if path.suffix == ".csv"} == {
        "mine.csv", "mine_parts.csv", "mine_later_parts.csv",
    }  # fmt: skip
    claims = pd.read_csv(tmp_path / "mine.csv")
    assert claims["verdict"].tolist() == ["not reproduced", "reproduced", "reproduced", "reproduced"]
    assert claims["later_verdict"].tolist() == ["reproduced", "reproduced", "reproduced", "undecided"]
    # What was there keeps its place, for those who read the file by column.
    assert list(claims.columns[:9]) == [
        "claim", "statement", "verdict", "value", "ci_low", "ci_high", "study", "what", "p",
    ]  # fmt: skip
    assert claims["later_what"].tolist()[0] == "either: plainly"
    assert claims["later_what"].tolist()[3] == "awaits Q-matrices that are carried"
    parts = pd.read_csv(tmp_path / "mine_later_parts.csv")
    assert parts["what"].tolist() == ["either: 8 / 4", "either: plainly", "size 4", "8 / 4"]
    assert parts.set_index("what").loc["size 4", ["others_passing", "others"]].tolist() == [0, 2]
    text = unpadded((tmp_path / "mine.md").read_text(encoding="utf-8"))
    assert "**4 claims: 3 reproduced, 1 not reproduced, 0 undecided.**" in text
    assert "By criteria that came later: 3 reproduced, 0 not reproduced, 1 undecided. Later verdicts came when" in text
    assert "0 of the 2 other values would pass" in text
    assert "the best value, world.size = 4, lies at the edge of its grid" in text
    assert (
        "- later criteria: 1 of 1 hold (placebo 0); without regard to intervals 1 are within their range (placebo 0)"
        in text
    )
    assert "larger, later" in (tmp_path / "mine.svg").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def larger(study: Study) -> tuple[Study, LearningReader]:
    """The same points with more periods, and a reader of both samples."""
    with planning() as planner:
        sweep = ["task.periods=60", *SWEEP[1:]]
        more = Study("more", (), planner.composer.config(()), plan_overrides(sweep, planner))
    return more, LearningReader(Plan((*study.plan, *more.plan)))


def test_later_verdicts_of_named_claims_rest_on_larger_samples_and_registered_ones_do_not(
    study: Study, larger: tuple[Study, LearningReader]
):
    more, reader = larger
    claims = {name: {"parts": [ratio(1.5)], "later": [ratio(1.5), best(4)]} for name in ("named", "other")}
    mine = replace(ledger(**claims), on_larger_samples=("named",))
    first = Runs.of_study(study, reader)
    named, other = mine.judged(first.with_larger(Runs.of_study(more, reader), "rl more"))
    assert (named.later_periods, other.later_periods) == ([60], [30])
    assert named.finding == other.finding == mine.judged(first)[0].finding
    assert named.later.decisive.value != other.later.decisive.value
    assert claims_frame([named, other])["later_periods"].tolist() == ["60", "30"]
    largest_world = next(planned for planned in more.plan if planned.parameters["world.size"] == 8)
    reader.missing = [largest_world.fingerprint]
    fallen_back, _ = mine.judged(first.with_larger(Runs.of_study(more, reader), "rl more"))
    reader.missing = []
    assert fallen_back.later_periods == [30]
    assert fallen_back.later.decisive == other.later.decisive


def test_a_claim_on_larger_samples_is_a_claim_of_the_ledger():
    nodes = {"a": {"statement": "says a", "study": "mine", "parts": [ratio(1.5)]}}
    values = {"title": "Claims", "common": {}, "claims": nodes, "on_larger_samples": ["b"]}
    with pytest.raises(ConfigError, match="on_larger_samples"):
        build("study.report", {"_target_": "rl_design_space.report.ClaimsLedger", **values})


def test_a_ledger_without_later_criteria_has_no_later_verdicts(study: Study):
    judged = ledger(larger={"parts": [ratio(1.5)]}).judged(Runs.of_study(study, LearningReader(study.plan)))
    assert "later_verdict" not in claims_frame(judged)


def test_later_verdicts_are_corrected_over_all_claims_and_registered_ones_within_their_study(study: Study):
    runs = Runs.of_study(study, LearningReader(study.plan))
    middle = [ratio(1.0, point={"world.size": 6}, to={"world.size": 4})]
    many = {f"claim {i}": {"parts": middle, "later": middle, "study": f"study {i}"} for i in range(4)}
    for each in ledger(**many).judged(runs):
        assert each.later is not None
        assert each.later.p == pytest.approx(4 * each.finding.p)


@pytest.mark.parametrize(
    ("claim", "message"),
    [
        (
            {"parts": [], "later": [ratio(1.5, paper=1.2)]},
            "claims.a.later.0: its range should admit the paper's own 1.2",
        ),
        ({"parts": [], "later": [either(ratio(1.5, paper=[[6, 5]]), ratio(2.0, paper=1.9))]}, "own 1.2, 1.9"),
        ({"parts": [ratio(1.5, paper=1.2)]}, "claims.a.parts.0: its range should admit the paper's own 1.2"),
        ({"parts": [], "later": [either(ratio(1.5), ratio(1.5, lo=2))]}, "claims.a.later.0.parts.1.lo: no such key"),
        (
            {"parts": [], "later": [{"_target_": f"{PARTS}.AnyOf", "what": "-", "parts": [ratio(1)]}]},
            "at least 2 items",
        ),
        ({"parts": [{"_target_": "rl_design_space.design.AdHoc"}]}, "should be an option of analysis.parts"),
    ],
    ids=str,
)
def test_a_later_range_that_the_papers_own_numbers_fail_is_refused_when_it_is_read(claim: dict, message: str):
    with pytest.raises(ConfigError) as caught:
        ledger(a=claim)
    assert message in str(caught.value)


def test_a_registered_range_that_the_papers_own_numbers_fail_stays_and_is_marked(study: Study):
    mine = ledger(a={"parts": [ratio(1.5, paper=1.2)], "later": [ratio(1.1, paper=1.2)]})
    (judged,) = mine.judged(Runs.of_study(study, LearningReader(study.plan)))
    assert judged.finding.parts[0].remarks == ("the paper's own 1.2 would fail this range",)
    assert judged.later is not None
    assert judged.later.parts[0].remarks == ()


@pytest.fixture(scope="module")
def shipped() -> ClaimsLedger:
    return build("study.report", yaml.safe_load((CONF / "study" / "claims.yaml").read_text(encoding="utf-8"))["report"])


def test_the_ranges_of_the_paper_admit_its_own_numbers_but_for_two_registered_ones(shipped: ClaimsLedger):
    def refusing(parts: tuple[Part, ...]) -> bool:
        return any(part.refused() for part in parts)

    assert [name for name, each in shipped.built.items() if refusing(each.registered)] == ["fig3-d", "t4-a"]
    assert [name for name, each in shipped.built.items() if refusing(each.later)] == []
    assert sum(len(getattr(part, "paper", ())) for each in shipped.built.values() for part in each.later) == 26


def test_the_documented_claims_are_built():
    page = (ROOT / "docs" / "reports.md").read_text(encoding="utf-8")
    (block,) = re.findall(r"```yaml mine/study/mine_claims\.yaml\n(.*?)```", page, re.DOTALL)
    assert [len(each.later) for each in build("study.report", yaml.safe_load(block)["report"]).built.values()] == [2, 1]
