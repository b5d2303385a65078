"""The order of values in reports."""

from typing import Any

import pytest

from rl_design_space.report.ordering import Ordering
from rl_design_space.tracking.selection import comparable


@pytest.mark.parametrize(
    ("listed", "expected"),
    [
        (["none", "length_3", "none", "direct"], ["none", "length_3", "direct"]),
        ([3, 1, 2], [1, 2, 3]),
        ([3, 2, 1], [3, 2, 1]),
        ([[10], [3], None, [10], [3, 5]], ["[10]", "[3]", "[3, 5]"]),
    ],
    ids=["texts", "ascending", "descending", "lists"],
)
def test_values_stand_as_a_study_lists_them(listed: list[Any], expected: list[Any]):
    ordering = Ordering.of_study({"name": listed})
    values = sorted({comparable(each) for each in listed if each is not None}, key=str)
    assert sorted(values, key=lambda value: ordering.key("name", value)) == expected
