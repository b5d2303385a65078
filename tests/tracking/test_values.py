"""Values that MLflow would not store unchanged are converted; names that it would refuse are rejected."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from rl_design_space.errors import ConfigError
from rl_design_space.tracking import values
from tests.tracking.stores import import_mlflow

# Before Hypothesis measures time.
import_mlflow()

NUMBERS = st.one_of(
    st.integers(-(2**60), 2**60),
    st.floats(),
    st.booleans(),
    st.integers(-100, 100).map(np.int32),
    st.floats(width=32).map(np.float32),
)


@given(NUMBERS)
@example(np.int64(3))
@example(math.inf)
@example(math.nan)
def test_a_metric_is_a_finite_float_or_none(number: object):
    stored = values.metric(number)
    if stored is None:
        assert not math.isfinite(float(number))
    else:
        assert type(stored) is float
        assert stored == float(number)


def test_a_metric_that_is_not_a_number_is_rejected():
    with pytest.raises(ConfigError, match="a metric should be a number, not 'fast'"):
        values.metric("fast")


@given(st.text(max_size=300).filter(lambda name: not name.endswith("\n")))
@example("steps/mean")
@example("a" * 250)
@example("a" * 251)
@example("a//b")
@example("/a")
@example("a/../b")
@example("..a")
@example(".")
@example("")
@example("representation=x")
def test_a_name_is_accepted_if_and_only_if_mlflow_accepts_it(name: str):
    from mlflow.exceptions import MlflowException
    from mlflow.utils.validation import _validate_metric_name, _validate_param_name, _validate_tag_name

    try:
        for check in (_validate_metric_name, _validate_param_name, _validate_tag_name):
            check(name)
        taken = len(name) <= values.KEY_LENGTH
    except MlflowException:
        taken = False
    if taken:
        assert values.key(name) == name
    else:
        with pytest.raises(ConfigError) as caught:
            values.key(name)
        assert str(caught.value).startswith(name[:40])


@given(st.one_of(st.text(), st.text(min_size=4990, max_size=6100), NUMBERS, st.lists(NUMBERS, max_size=5)))
@example("x" * 10_000)
@example([np.int64(2), 3])
def test_a_text_is_short_enough(value: object):
    from mlflow.utils.validation import MAX_PARAM_VAL_LENGTH, MAX_TAG_VAL_LENGTH

    assert len(values.param(value)) <= min(values.PARAM_LENGTH, MAX_PARAM_VAL_LENGTH)
    assert len(values.tag(value)) <= min(values.TAG_LENGTH, MAX_TAG_VAL_LENGTH)
    assert "np." not in values.param(value) or isinstance(value, str)


@given(st.text(max_size=5), st.text(max_size=5))
def test_long_texts_that_differ_stay_different(one: str, other: str):
    long = "x" * 7000
    assert (values.param(long + one) == values.param(long + other)) == (one == other)


def test_a_numpy_number_is_written_like_a_python_number():
    assert values.param([np.float64(0.5), np.int32(2)]) == values.param([0.5, 2]) == "[0.5, 2]"
