"""Params that were written to do harm are read as text."""

from __future__ import annotations

import pytest

from rl_design_space.tracking.run_frame import typed


@pytest.mark.parametrize(
    "text",
    [
        "{a: &a {x: 1}, b: {<<: [*a, *a]}}", "a: &a [*a]", "!!python/object/apply:os.getcwd []", "2020-99-99",
        "9" * 5000, "-" + "9" * 5000, "9" * 5000 + ".5", "[" * 5000,
    ],
)  # fmt: skip
def test_a_hostile_param_is_text(text: str):
    assert typed(text) == text
