"""Constraints: combinations of a study that are left out."""

from __future__ import annotations

import pytest

from rl_design_space.errors import ConfigError
from rl_design_space.plan.plan import Dropped

SIZES = {"a": {"world.size": "4,6", "msa": "none,length_3,length_5"}}
TOO_LONG = {"drop": "max(msa.lengths, default=1) >= min(world.shape)", "why": "goes all the way round"}


def test_a_constraint_drops_points_and_counts_them(planned):
    found = planned(SIZES, constraints={"too_long": TOO_LONG})
    assert [p.name for p in found] == [
        "world.size=4 msa=none",
        "world.size=4 msa=length_3",
        *(f"world.size=6 msa={msa}" for msa in ("none", "length_3", "length_5")),
    ]
    assert found.dropped == (Dropped("mine", "too_long", "goes all the way round", 1),)
    assert (found.combinations, found.duplicates) == (6, 0)


def test_a_point_is_dropped_by_the_first_constraint_that_applies(planned):
    every = {"drop": "world.size == 4", "why": "small"}
    found = planned(SIZES, constraints={"too_long": TOO_LONG, "small": every, "never": {"drop": "False", "why": "-"}})
    assert [(dropped.constraint, dropped.count) for dropped in found.dropped] == [("small", 2), ("too_long", 1)]
    assert len(found) == 3


@pytest.mark.parametrize(
    ("drop", "left"),
    [
        ("representation == 'direction'", {"ad_hoc"}),
        ("representation in {'ad_hoc'}", {"direction"}),
        ("representation == 'direction' and representation.goals == 'remaining'", {"ad_hoc"}),
        ("task.goals < 3 or seed > 0 or world.size != 10", {"ad_hoc", "direction"}),
    ],
)
def test_an_expression_knows_options_by_name_and_values_by_key(planned, drop: str, left: set[str]):
    found = planned({"a": {"representation": "ad_hoc,direction"}}, constraints={"c": {"drop": drop, "why": "because"}})
    assert {p.options["representation"] for p in found} == left


def test_invalid_combinations_may_be_dropped(planned):
    # Four goals and the start do not fit on four cells.
    blocks = {"a": {"world.size": "2,3", "task.goals": "3,4"}}
    with pytest.raises(ConfigError, match=r"task\.goals=4: start and goals lie on different cells"):
        planned(blocks)
    room = {"drop": "task.goals >= world.shape[0] * world.shape[1]", "why": "no room"}
    assert len(planned(blocks, constraints={"room": room})) == 3


@pytest.mark.parametrize(
    ("constraints", "message"),
    [
        ({"c": {"drop": "world.siz > 3", "why": "-"}}, "block a: constraint c: drop=world.siz > 3: "),
        ({"c": {"drop": "open('x')", "why": "-"}}, "open: no such function"),
        ({"c": {"drop": "wurld.size > 3", "why": "-"}}, "wurld: no such name; did you mean world?"),
        ({"c": {"drop": "world.offset", "why": "-"}}, "world.offset: no such value"),
        ({"c": {"drop": "task == 3", "why": "-"}}, "task: name one of its values: task.goals, "),
        ({"c": {"drop": "().__class__", "why": "-"}}, "().__class__: not part of an expression"),
        ({"c": {"drop": "9**9**9 > 1", "why": "-"}}, "drop=9**9**9 > 1: an exponent is at most 64"),
        ({"c": {"drop": "world.size >", "why": "-"}}, "should be a Python expression"),
        ({"c": {"drop": "True"}}, "study mine, constraints.c.why=???: needs a value"),
        ({"c": {"keep": "True", "why": "-"}}, "constraints.c.drop=???: needs a value\nconstraints.c.keep: no such key"),
        ({"c": {"drop": "True", "why": "-", "wy": "-"}}, "wy: no such key; did you mean constraints.c.why?"),
        ({"c": "True"}, "should be a mapping of names to {drop: EXPRESSION, why: REASON}"),
        (["True"], "should be a mapping of names to {drop: EXPRESSION, why: REASON}"),
        ({"c": {"drop": "True", "why": "-"}}, "its constraints drop all 6 combinations"),
    ],
    ids=str,
)
def test_an_invalid_constraint_is_explained(planned, constraints: object, message: str):
    with pytest.raises(ConfigError) as caught:
        planned(SIZES, constraints=constraints)
    assert message in str(caught.value)
    assert str(caught.value).startswith("study mine")


# Several studies.
