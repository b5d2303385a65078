"""Factorials: full ones, unions of grids, and what nothing can be said about."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from rl_design_space.analysis.factorial import Grids, factors, grids
from rl_design_space.errors import ConfigError


def points(**values):
    return [dict(zip(values, each, strict=True)) for each in product(*values.values())]


def shapes(found: Grids) -> list[dict[str, int]]:
    return [dict(zip((f.name for f in part.factors), part.points.shape, strict=True)) for part in found.parts]


def test_a_full_factorial_is_one_part_with_each_point_in_its_place():
    there = points(a=[1, 2, 3], b="xy", c=[0.1, 0.2])
    found = grids(there[::-1], ["a", "b", "c"])
    assert found.is_whole
    assert shapes(found) == [{"a": 3, "b": 2, "c": 2}]
    (part,) = found.parts
    for place in np.ndindex(part.points.shape):
        point = there[::-1][part.points[place]]
        assert [point[name] for name in "abc"] == [part.levels[axis][level][0] for axis, level in enumerate(place)]


def test_schedules_with_values_of_their_own_are_levels_of_one_factor():
    there = points(exploration=["linear"], **{"exploration.k": [0.02, 0.05]}) + points(
        exploration=["exponential"], **{"exploration.l": [2.0, 3.0]}
    )
    there = [{**point, "reward": reward} for point in there for reward in "ab"]
    names = ["exploration", "exploration.k", "exploration.l", "reward"]
    assert [factor.name for factor in factors(there, names)] == ["exploration", "reward"]
    assert shapes(grids(there, names)) == [{"exploration": 4, "reward": 2}]


def test_a_union_of_grids_is_taken_apart_into_the_largest_ones():
    sets = ["none", "l2", "l3", "l5", "l23"]
    union = [
        *points(r=["ad"], k=[3, 7], m=sets),
        *points(r=["di"], k=[2, 5], m=sets),
        *points(r=["ad", "di"], k=range(1, 9), m=["none", "l3"]),
    ]
    there = list({tuple(point.values()): point for point in union}.values())
    found = grids(there, ["r", "k", "m"])
    assert shapes(found) == [{"k": 8, "m": 2, "r": 2}, {"k": 2, "m": 5}, {"k": 2, "m": 5}] or shapes(found) == [
        {"r": 2, "k": 8, "m": 2}, {"k": 2, "m": 5}, {"k": 2, "m": 5}
    ]  # fmt: skip
    assert (found.alone, found.unknown, found.is_whole) == (0, (), False)


def test_one_missing_cell_costs_one_level_at_most():
    there = points(a=range(4), b=range(5))
    found = grids(there[:-1], ["a", "b"])
    assert shapes(found)[0] == {"a": 4, "b": 4}
    assert found.empty == ("a=3 b=4",)
    assert found.alone == 0
    assert {int(index) for part in found.parts for index in part.points.flat} == set(range(19))


def test_a_choice_that_follows_from_another_is_named_with_the_empty_cells():
    there = [{"a": 1, "b": 1, "c": c} for c in "xyz"] + [{"a": 2, "b": 2, "c": c} for c in "xyz"]
    found = grids(there, ["a", "b", "c"])
    assert found.unknown == ("a", "b")
    assert found.empty[0] == "a=1 b=2 c=x"
    assert "6 of 12 combinations have no point" in found.gap
    with pytest.raises(ConfigError, match="2 of 4 combinations have no point: a=1 b=2; a=2 b=1; run them"):
        grids([{"a": 1, "b": 1}, {"a": 2, "b": 2}], ["a", "b"])


def test_a_random_search_is_refused_at_once():
    rng = np.random.default_rng(1)
    there = [dict(zip("abc", each, strict=True)) for each in rng.random((300, 3)).tolist()]
    with pytest.raises(ConfigError, match=r"a, b, c: 26,999,700 of 27,000,000 combinations have no point"):
        grids(there, ["a", "b", "c"])
