"""Parts about whole grids and tables: nothing is selected, so nothing is wasted and nothing is lucky."""

from __future__ import annotations

import numpy as np
import pytest
from pydantic import ValidationError

from rl_design_space.analysis.parts import (
    AllOf,
    AllOver,
    AnyOf,
    BestOverBest,
    Difference,
    ExpectedOverBest,
    ExplorationOverExploration,
    JointRatio,
    Level,
    Ratio,
    TypicalOverTypical,
    WithinOfAll,
)
from tests.analysis.made_up import MadeUp, MadeUpData

#: Steps until trial `until` are ten times those after it.
SLOPES = {0.01: MadeUp(until=12), 0.03: MadeUp(until=4), 0.05: MadeUp(until=4, noise=0.06), 0.1: MadeUp(until=8)}
DATA = MadeUpData(
    {"fast": MadeUp(until=4), "slow": MadeUp(until=12), "never": MadeUp(until=99), "other": MadeUp(last=50.0, until=4)},
    {
        "slopes": SLOPES,
        "sigmoidal": {1: MadeUp(until=3), 2: MadeUp(until=16), 3: MadeUp(until=18)},
        "rising": {k: MadeUp(until=until, exploration=until) for k, until in ((0.1, 2), (0.2, 4), (0.3, 6))},
    },
)


def within(expected: float, among: str = "slopes", **more: object):
    part = WithinOfAll(
        what="-", among={"name": among}, parameter="k", expected=expected, measure="total_steps", high=1.05, **more
    )
    return part.test(DATA)


def test_a_value_within_5_percent_of_every_other_is_a_best_one():
    tested = within(0.03)
    assert tested.state == "holds"
    assert tested.ci_high <= 1.05
    # 0.05 is as good, so the test would not have told it from the claimed value; the two others fail.
    assert tested.severity == (1, 3, True, 1)
    worst = within(0.1)
    assert worst.state == "fails"
    assert worst.value == pytest.approx(MadeUp(until=8).steps.sum() / MadeUp(until=4).steps.sum(), 0.01)
    assert worst.p_other < 0.001


def test_all_periods_are_used_where_halving_leaves_a_claim_undecided():
    # Noise that half of the periods cannot average out.
    class Noisy(MadeUp):
        @property
        def steps(self):
            spread = np.exp(0.25 * np.random.default_rng(self.until).normal(size=(self.periods, 1)))
            return np.round(super().steps * spread).astype(np.int32)

    data = MadeUpData({}, {"noisy": {1: Noisy(until=6, periods=400), 2: Noisy(until=7, periods=400)}})
    fields = {"what": "-", "among": {"name": "noisy"}, "parameter": "k", "expected": 1, "measure": "total_steps"}
    halved, whole = (kind(**fields, high=1.05).test(data) for kind in (ExpectedOverBest, WithinOfAll))
    assert whole.state == "holds"
    assert 0 < whole.ci_high - whole.ci_low < 0.1
    # The half that is judged is compared with itself, or with less than half of the information.
    assert halved.value == 1.0 or halved.ci_high - halved.ci_low > 1.3 * (whole.ci_high - whole.ci_low)


@pytest.mark.parametrize(
    ("expected", "remarked"), [(0.1, ["best value, k = 0.1"]), (0.3, ["best value, k = 0.1", "claimed value, k = 0.3"])]
)
def test_a_best_value_at_the_edge_of_its_grid_is_remarked_on(expected: float, remarked: list[str]):
    edges = [remark for remark in within(expected, "rising").remarks if "edge" in remark]
    assert edges == [f"the {each}, lies at the edge of its grid" for each in remarked]
    fields = {"among": {"name": "rising"}, "to": {"name": "slopes"}, "parameter": "k", "measure": "total_steps"}
    for part in (ExplorationOverExploration, BestOverBest):
        assert part(what="-", **fields).test(DATA).remarks == ("the best value, k = 0.1, lies at the edge of its grid",)


def test_every_point_of_a_grid_over_one_point():
    part = AllOver(
        what="-", among={"name": "slopes"}, parameter="k", to={"name": "fast"}, measure="total_steps", low=1.5
    )
    tested = part.test(DATA)
    assert tested.state == "fails"  # 0.03 is as fast
    assert tested.remarks == ("decided by k = 0.03",)
    part = AllOver(
        what="-", among={"name": "sigmoidal"}, parameter="k", to={"name": "fast"}, measure="total_steps", low=0.5
    )
    assert part.test(DATA).state == "holds"


def test_what_is_usual_in_a_grid_is_not_its_best():
    fields = {"what": "-", "among": {"name": "sigmoidal"}, "to": {"name": "slopes"}, "parameter": "k", "low": 1.2}
    assert BestOverBest(**fields, measure="total_steps").test(DATA).state == "fails"
    typical = TypicalOverTypical(**fields, measure={"gap_closed": 0.9}).test(DATA)
    assert (typical.value, typical.state) == (16 / 6, "holds")


def test_a_joint_ratio_is_one_question_about_all_cells():
    class Cells(MadeUpData):
        def one(self, where):
            return MadeUp(
                last=10.0 * where["n"] * (where["by"] if where["who"] == "a" else 1.0), periods=where["n"] * 40
            )

    def joint(by: list[float], **more: object):
        cells = {"by": by, "n": [1, 2]}
        return JointRatio(what="-", point={"who": "a"}, to={"who": "b"}, cells=cells, measure="steps_after=10", **more)

    tested = joint([2.0, 0.5], low=0.8, high=1.25).test(Cells({}))
    assert tested.value == pytest.approx(1.0, abs=0.001)
    assert tested.state == "holds"
    assert tested.remarks == ("single cells from 0.5 to 2",)
    assert joint([2.0, 1.0], low=0.8, high=1.25).test(Cells({})).state == "fails"
    # The paper's own cells count by their mean, too.
    assert joint([1.0], low=0.8, high=1.25, paper=[1.3, [16, 20]]).refused() == ()
    assert joint([1.0], low=0.8, high=1.25, paper=[1.3, 1.3]).refused() == (pytest.approx(1.3),)


def test_a_cell_whose_points_have_other_numbers_of_periods_is_not_paired():
    class Cells(MadeUpData):
        def one(self, where):
            return MadeUp(periods=where["periods"])

    part = JointRatio(
        what="-", point={"periods": 50}, to={"periods": 200}, cells={"n": [1]}, measure="total_steps", high=1.1
    )
    tested = part.test(Cells({}))
    assert tested.ci_low < 1 < tested.ci_high < 1.1


SLOWER = Difference(what="slower", point={"name": "slow"}, to={"name": "fast"}, measure="gap_closed", low=1.0)
FASTER = Difference(what="faster", point={"name": "fast"}, to={"name": "slow"}, measure="gap_closed", low=1.0)


def test_one_of_several_parts_is_enough_or_not():
    either = AnyOf(what="either", parts=(SLOWER, FASTER)).test(DATA)
    both = AllOf(what="both", parts=(SLOWER, FASTER)).test(DATA)
    assert (either.state, both.state) == ("holds", "fails")
    assert either.p_claim == pytest.approx(2 / 5001)
    assert either.deciding()[0] == "either: slower"
    assert both.deciding()[0] == "both: faster"
    nested = AnyOf(what="or", parts=(FASTER, AllOf(what="and", parts=(SLOWER, SLOWER)))).test(DATA)
    assert nested.state == "holds"
    assert [what for what, _ in nested.leaves()] == ["or: faster", "or: and: slower", "or: and: slower"]


def test_a_curve_that_ends_worse_is_not_faster():
    # trials_to_final measures to a curve's own end: one that falls to 50 is "as fast" as one that falls to 10.
    by_end, by_gap = (
        Difference(what="-", point={"name": "other"}, to={"name": "fast"}, measure=name, low=1.0).test(DATA)
        for name in ("trials_to_final", "gap_closed=0.9")
    )
    assert by_end.state == "fails"
    assert (by_gap.state, by_gap.sign, by_gap.value) == ("holds", "≥", 16)


def test_never_is_a_bound_and_is_not_divided_by():
    over = Ratio(what="-", point={"name": "never"}, to={"name": "slow"}, measure="gap_closed", low=1.5, high=2.5).test(
        DATA
    )
    assert (over.sign, over.value, over.ci_high) == ("≥", pytest.approx(20 / 12), np.inf)
    assert over.state == "unclear"  # at least 1.67 may be more than 2.5
    under = Ratio(what="-", point={"name": "slow"}, to={"name": "never"}, measure="gap_closed", high=0.7).test(DATA)
    assert (under.state, under.p_claim, under.p_other) == ("unclear", 1.0, 1.0)
    neither = Ratio(what="-", point={"name": "never"}, to={"name": "never"}, measure="gap_closed", high=1.0).test(DATA)
    assert (neither.state, neither.p_claim, neither.p_other) == ("unclear", 1.0, 1.0)
    level = Level(what="-", point={"name": "never"}, measure="gap_closed", high=15.0).test(DATA)
    assert (level.sign, level.value, level.state) == ("≥", 20, "fails")


@pytest.mark.parametrize(
    ("given", "refused"), [(1.2, ()), ([1.2, [3, 2]], ()), ([[4, 2]], (2.0,)), ([1.0, 1.7], (1.7,))], ids=str
)
def test_a_range_admits_the_papers_own_numbers_or_names_those_that_it_refuses(given: object, refused: tuple):
    part = Ratio(what="-", point={"a": 1}, to={"a": 2}, measure="total_steps", low=0.5, high=1.5, paper=given)
    assert part.refused() == refused
    inside = Ratio(what="-", point={"a": 1}, to={"a": 2}, measure="total_steps", low=0.5)
    assert AllOf(what="-", parts=(part, inside)).refused() == refused
    assert AnyOf(what="-", parts=(part, inside)).refused() == ()


@pytest.mark.parametrize("values", [{"paper": "1.3"}, {"paper": [[1, 0]]}, {"measure": "near_share"}], ids=str)
def test_what_a_best_value_cannot_have_is_refused(values: dict):
    fields = {"measure": "total_steps", "among": {"a": 1}, "parameter": "k", "expected": 1, **values}
    with pytest.raises(ValidationError, match=r"should be (numbers of the paper|one of which the smallest)"):
        WithinOfAll(what="-", **fields)


def test_a_measure_of_later_trials_lacks_points_in_a_quick_look():
    with pytest.raises(LookupError, match="steps_after=30: there are only 20 trials"):
        Level(what="-", point={"name": "fast"}, measure="steps_after=30").test(DATA)


@pytest.mark.parametrize(("low", "state"), [(0.9, "fails"), (0.01, "unclear")])
def test_a_share_of_0_in_n_has_an_interval(low: float, state: str):
    # 0 in 60 periods: the true share may well be 0.01.
    tested = Level(what="-", point={"name": "fast"}, measure="final_failed", low=low).test(DATA)
    assert (tested.value, tested.ci_low, tested.state) == (0, 0, state)
    assert tested.ci_high == pytest.approx(1.96**2 / (60 + 1.96**2), abs=1e-4)
    assert (tested.p_other < 0.05) == (state == "fails")


def test_a_difference_of_shares_of_0_in_n_has_an_interval():
    both = {"point": {"name": "fast"}, "to": {"name": "slow"}}
    tested = Difference(what="-", **both, measure="final_failed", low=0.0).test(DATA)
    assert (tested.ci_low, tested.value, tested.ci_high) == (pytest.approx(-0.06, abs=0.001), 0, -tested.ci_low)
    assert (tested.state, tested.p_claim) == ("unclear", 1.0)
