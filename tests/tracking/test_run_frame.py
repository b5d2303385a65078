"""Params as they were before MLflow made text of them."""

from __future__ import annotations

import math

import pytest

from rl_design_space.tracking.run_frame import typed


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("3", 3), ("-0.5", -0.5), ("1e-05", 1e-05), ("1.5e+3", 1500.0), ("true", True), ("False", False),
        ("0x1f", 31), (".inf", math.inf), (None, None),
    ],
)  # fmt: skip
def test_numbers_and_truth_values_are_typed(text: str | None, value: object):
    assert repr(typed(text)) == repr(value)


@pytest.mark.parametrize(
    "text",
    [
        "ad_hoc", "[1, 2]", "null", "2020-99-99", "{a: &a {x: 1}, b: {<<: [*a, *a]}}", "!!int 5", "9" * 5000,
        "-" + "9" * 5000, "0x" + "_" * 10, "[" * 5000, "a: &a [*a]", "",
    ],
)  # fmt: skip
def test_all_else_is_text_whoever_has_written_it(text: str):
    assert typed(text) == text
