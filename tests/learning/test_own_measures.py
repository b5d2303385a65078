"""Measures of the user's own."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from rl_design_space.errors import ConfigError
from rl_design_space.learning.measures import canonical, measure
from tests.analysis.made_up import MadeUp

EQUAL = np.full((1, 60), 1 / 60)
SOURCE = '''
import numpy as np

def late(periods, share=0.5):
    """Steps of the later trials.

    More text.
    """
    trials = periods.steps.shape[1]
    return periods.steps[:, int(trials * (1 - share)):].sum(axis=1)

def worst(curves):
    """Largest value {of a curve}."""
    return curves.max(axis=-1)

def shapeless(periods): return periods.steps
def textual(periods): return np.array(["x"] * len(periods.steps))
def holed(periods): return np.where(np.arange(len(periods.steps)) < 3, np.nan, 1.0)
def broken(periods): return 1 // 0
def other(argument): return argument
def needy(periods, factor): return periods.total_steps * factor
'''


@pytest.fixture(scope="module", autouse=True)
def module(tmp_path_factory: pytest.TempPathFactory):
    folder: Path = tmp_path_factory.mktemp("own")
    (folder / "own_for_test.py").write_text(SOURCE)
    with pytest.MonkeyPatch.context() as patched:
        patched.syspath_prepend(str(folder))
        yield


def value(spec: object) -> float:
    return float(measure(spec).samples(MadeUp(), EQUAL)[0])  # type: ignore[arg-type]


def test_a_function_of_periods_is_a_measure_with_parameters_and_a_statistic():
    steps = MadeUp().steps
    assert value("own_for_test.late") == pytest.approx(steps[:, 10:].sum(axis=1).mean())
    expected = steps[:, 15:].sum(axis=1)
    assert value({"_target_": "own_for_test.late", "share": 0.25}) == pytest.approx(expected.mean())
    assert value("own_for_test.late,share=0.25,statistic=median") == pytest.approx(np.median(expected))
    assert measure("own_for_test.late").meaning == "Steps of the later trials, mean over periods"
    each = measure("own_for_test.late,share=0.25").each(MadeUp())
    assert each is not None
    assert np.array_equal(each, expected)


def test_a_function_of_curves_is_a_measure():
    assert value("own_for_test.worst") == pytest.approx(MadeUp().over_optimum.mean(axis=0).max())
    assert measure("own_for_test.worst,statistic=median").meaning == "Largest value {of a curve}, of the median curve"


@pytest.mark.parametrize(
    ("spec", "message"),
    [
        ("own_for_test.shapeless", "should return numbers of shape (60,), not int32 (60, 20)"),
        ("own_for_test.textual", "should return numbers of shape (60,), not <U1 (60,)"),
        ("own_for_test.holed", "measure own_for_test.holed: 3 of its 60 numbers are NaN or infinite"),
        ("own_for_test.broken", "measure own_for_test.broken: ZeroDivisionError: "),
        ("own_for_test.other", "should be a function whose first argument is called periods or curves"),
        ("own_for_test.needy", "measure own_for_test.needy: missing a required argument: 'factor'"),
        ("own_for_test.late,shares=1", "shares: no such parameter; did you mean"),
        ("own_for_test.nothing", "cannot be imported: module 'own_for_test' has no attribute 'nothing'"),
        ("no_such_module.nothing", "cannot be imported: No module named 'no_such_module'"),
        ("own_for_test.late=3", "should name the parameter: my_module.my_measure,parameter=3"),
    ],
)
def test_what_is_wrong_is_named_with_the_measure(spec: str, message: str):
    with pytest.raises(ConfigError) as raised:
        value(spec)
    assert message in str(raised.value)
    assert spec.partition(",")[0].partition("=")[0] in str(raised.value)


def test_the_name_of_an_own_measure_imports_nothing():
    assert canonical("no_such_module.nothing") == "no_such_module.nothing"
