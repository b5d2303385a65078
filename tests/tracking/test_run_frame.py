"""Params of MLflow, which are text, as the values that they were."""

from __future__ import annotations

import pytest

from rl_design_space.tracking.run_frame import typed
from rl_design_space.tracking.values import param


@pytest.mark.parametrize(
    "value",
    [
        *(0, -3, 10**20, 0.5, -2.0, 1e-05, 2.5e-07, 1e22, True, False, "ad_hoc", "010", "1:30", "2020-99-99", "1_000"),
        *("2020-01-01", "yes", "", "null", "0x1f", ".5.", "inf", "[1, 2]", "a: b", "!x", "{"),
    ],
    ids=str,
)
def test_a_param_has_the_value_that_was_recorded(value: object):
    assert typed(param(value)) == value
    assert type(typed(param(value))) is type(value)


def test_a_missing_param_has_no_value():
    assert typed(None) is None
