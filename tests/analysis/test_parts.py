"""Parts of claims on synthetic points: each result follows the data."""

from __future__ import annotations

import math

import numpy as np
import pytest
from pydantic import ValidationError

from rl_design_space.analysis import resampling
from rl_design_space.analysis.bounds import Bounds
from rl_design_space.analysis.parts import (
    BestOverBest,
    Difference,
    ExpectedOverBest,
    ExplorationOverExploration,
    KnownObservations,
    Level,
    Ratio,
)
from rl_design_space.analysis.parts.measured import ODD, measured, measured_each, weightings
from rl_design_space.analysis.statistics import Resamples
from rl_design_space.design import AdHoc, Direction, Distance
from rl_design_space.errors import ConfigError
from rl_design_space.learning.measures import measure
from tests.analysis.made_up import MadeUp, MadeUpData

FAST, SLOW = MadeUp(until=4), MadeUp(until=12)
DATA = MadeUpData(
    {"fast": FAST, "slow": SLOW},
    {
        "slopes": {0.01: SLOW, 0.03: FAST, 0.05: MadeUp(until=8)},
        "others": {0.01: MadeUp(until=16, exploration=6.0), 0.03: MadeUp(until=15, exploration=2.0)},
    },
)
ONE, OTHER = {"name": "slow"}, {"name": "fast"}


def test_a_level_is_a_measure_of_a_point():
    tested = Level(what="speed", point=ONE, measure="trials_to_final", high=12.0).test(DATA)
    assert (tested.what, tested.value, tested.low, tested.high) == ("speed", 12, -math.inf, 12)
    assert tested.state == "holds"
    assert Level(what="speed", point=ONE, measure="trials_to_final", high=11.0).test(DATA).state == "fails"


def test_ratios_and_differences_are_paired():
    ratio = Ratio(what="-", point=ONE, to=OTHER, measure="total_steps", low=1.0).test(DATA)
    expected = SLOW.steps.sum() / FAST.steps.sum()
    assert ratio.value == pytest.approx(expected)
    # All periods of a point are slow or fast together with those of the other, so nothing is left to chance.
    assert ratio.ci_high - ratio.ci_low < 0.01
    assert Ratio(what="-", point=OTHER, to=ONE, measure="total_steps", low=1.0).test(DATA).state == "fails"
    difference = Difference(what="-", point=ONE, to=OTHER, measure="trials_to_final", low=5.0, high=15.0).test(DATA)
    assert (difference.value, difference.state) == (8, "holds")


def test_a_resampled_measure_is_computed_once_for_each_result():
    def of(name: str, recorded: MadeUp, half: slice = slice(None)) -> Bounds:
        return measured(name, recorded, weightings(recorded, half)[1])

    first = of("total_steps", FAST)
    assert of("total_steps", FAST) is first
    others = [of("late_steps", FAST), of("total_steps", SLOW), of("total_steps", FAST, ODD)]
    assert len({each.low[0] for each in (first, *others)}) == 4


@pytest.mark.parametrize("name", ["total_steps", "failed_trials", "trials_to_final", "late_steps,statistic=median"])
def test_points_measured_together_have_the_numbers_of_each_alone_bit_for_bit(
    name: str, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(resampling, "AT_ONCE", 100_000)  # several blocks, as of many periods
    points = [MadeUp(until=until, failed=until / 100) for until in (4, 8, 12)]
    for weights in weightings(points[0], ODD):
        together = measured_each(name, points, weights)
        blocks = list(weights.blocks()) if isinstance(weights, Resamples) else [weights]
        for point, found in zip(points, together, strict=True):
            alone = np.concatenate([measure(name).samples(point, block) for block in blocks])
            assert np.array_equal(found.low, alone)


@pytest.mark.parametrize("part", [Ratio, Difference])
def test_points_with_other_periods_are_not_paired(part: type[Ratio]):
    data = MadeUpData({"fast": FAST, "slow": MadeUp(periods=30)}, {})
    with pytest.raises(ConfigError, match=r"seed, task\.periods: points of 30 and 60 periods cannot be compared"):
        part(what="-", point=ONE, to=OTHER, measure="total_steps", low=1.0).test(data)


@pytest.mark.parametrize(("expected", "state"), [(0.03, "holds"), (0.01, "fails")])
def test_the_best_of_a_parameter(expected: float, state: str):
    part = ExpectedOverBest(
        what="-", among={"name": "slopes"}, parameter="k", expected=expected, measure="total_steps", high=1.05
    )
    assert part.test(DATA).state == state
    assert part.test(DATA).value == pytest.approx(
        1.0 if expected == 0.03 else SLOW.steps.sum() / FAST.steps.sum(), 0.02
    )


def test_a_value_that_no_point_has_cannot_be_the_best():
    part = ExpectedOverBest(
        what="-", among={"name": "slopes"}, parameter="k", expected=0.2, measure="total_steps", high=1.05
    )
    with pytest.raises(LookupError, match=r"k=0\.2: there is no such point"):
        part.test(DATA)


def test_the_best_is_selected_on_one_half_and_compared_on_the_other():
    # The even periods of one are fast and its odd ones slow: chosen for the ones, it is judged by the others.
    class Lucky(MadeUp):
        @property
        def steps(self):
            steps = super().steps.copy()
            steps[0::2] //= 10
            steps[1::2] *= 10
            return steps

    lucky, plain = Lucky(noise=0.0), MadeUp(noise=0.0)
    data = MadeUpData({}, {"points": {1: lucky, 2: plain}, "reference": {1: plain}})
    part = BestOverBest(
        what="-", among={"name": "points"}, parameter="k", to={"name": "reference"}, measure="total_steps", high=1.0
    )
    tested = part.test(data)
    assert tested.value == pytest.approx(10)
    assert tested.state == "fails"


def test_best_over_best():
    part = BestOverBest(
        what="-", among={"name": "others"}, parameter="k", to={"name": "slopes"}, measure="total_steps", low=1.5
    )
    assert part.test(DATA).value == pytest.approx(MadeUp(until=15).steps.sum() / FAST.steps.sum(), 0.01)
    assert part.test(DATA).state == "holds"


def test_exploration_is_that_of_the_best_schedule():
    part = ExplorationOverExploration(
        what="-", among={"name": "others"}, to={"name": "slopes"}, parameter="k", measure="total_steps", low=1.5
    )
    tested = part.test(DATA)
    assert (tested.value, tested.ci_low, tested.state) == (2.0, 2.0, "holds")


@pytest.mark.parametrize(
    ("representation", "share"), [(Direction(), 1.0), (AdHoc(), 100 / 900), (Distance(), 11 / 31)], ids=str
)
def test_observations_known_from_a_smaller_world(representation, share: float):
    tested = KnownObservations(what="-", representation=representation, sizes=(10, 30), low=1.0).test(DATA)
    assert tested.value == pytest.approx(share)
    assert tested.state == ("holds" if share == 1 else "fails")


def test_a_point_that_is_missing_is_named():
    with pytest.raises(LookupError, match="missing: nobody"):
        Level(what="-", point={"name": "nobody"}, measure="total_steps").test(DATA)


@pytest.mark.parametrize(
    "values",
    [{"measure": "speed"}, {"measure": "total_steps", "hi": 1.0}, {"measure": "total_steps", "high": "1"}],
    ids=str,
)
def test_an_invalid_part_is_refused(values: dict):
    with pytest.raises(ValidationError):
        Level(what="-", point=ONE, **values)
