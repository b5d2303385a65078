"""Runs of earlier code are left out by one rule, and values are matched as the command line writes them."""

from __future__ import annotations

import pytest

from rl_design_space.errors import ConfigError
from rl_design_space.tracking.found_run import FoundRun
from rl_design_space.tracking.selection import LEARNING, changed_since, chosen, left_out, outdated


def run(run_id: str, started: int, fingerprint: str | None = None, **params: str) -> FoundRun:
    named = {name.replace("__", "."): value for name, value in params.items()}
    return FoundRun(run_id, "", started, started, "", named, {}, {"fingerprint": fingerprint or run_id})


def test_the_code_of_the_latest_run_counts_option_by_option():
    runs = [
        run("rings, new", 3, representation="rings", representation__source="sha256:new"),
        run("rings, old", 1, representation="rings", representation__source="sha256:old"),
        run("way", 2, representation="way", representation__source="sha256:old"),
        run("maze, new", 5, representation="ad_hoc", world="maze", world__source="version 2"),
        run("maze, old", 4, representation="ad_hoc", world="maze", world__source="version 1"),
        run("torus", 0, representation="ad_hoc", world="torus"),
    ]
    assert outdated(runs) == {"rings, old": "representation=rings", "maze, old": "world=maze"}
    assert outdated(runs[:1] + runs[2:4]) == {}


def test_a_component_inside_another_one_has_code_of_its_own():
    old, new = (
        run(f"{source}", number, representation="pair", representation__first__source=source)
        for number, source in enumerate(("version 1", "version 2"))
    )
    assert outdated([new, old]) == {"version 1": "representation=pair.first"}


def test_of_equal_points_those_of_an_earlier_learning_algorithm_are_outdated():
    runs = [run("old", 1, reward="a"), run("new", 2, reward="a"), run("other", 0, reward="b")]
    assert outdated(runs) == {"old": LEARNING}
    twice = [run("one", 1, "same", reward="a"), run("two", 2, "same", reward="a")]  # recorded by two machines
    assert outdated(twice) == {}


def test_points_run_again_because_something_was_changed_since():
    from rl_design_space.plan.plan import PlannedPoint
    from rl_design_space.tracking.record import params
    from tests.tracking.stores import learned

    planned: PlannedPoint = learned()[0]
    now = params(planned.parameters)
    code = {"representation.source": "version 1"}
    assert changed_since([planned], [FoundRun("a", "", 0, 0, "", {**now, "seed": "7"})]) == {}
    assert changed_since([planned], [FoundRun("a", "", 0, 0, "", now)]) == {LEARNING: 1}
    assert changed_since([planned], [FoundRun("a", "", 0, 0, "", {**now, **code})]) == {LEARNING: 1}


def test_the_note_says_how_many_and_what_was_changed():
    assert left_out({}, 5) == ""
    old = {"1": "representation=rings", "2": "world=maze", "3": "world=maze"}
    assert left_out(old, 5) == "left out: 3 of 5 runs, recorded with earlier code of representation=rings, world=maze"


@pytest.mark.parametrize(
    ("where", "found"),
    [
        ({"k": 0.02}, "a"),
        ({"k": [0.02, 0.1]}, "ab"),
        ({"lengths": [2, 3]}, "b"),  # the list itself
        ({"lengths": "[2, 3]"}, "b"),
        ({"periods": 30}, "abc"),
        ({"periods": 30.0, "k": "0.1"}, "b"),
        ({}, "abc"),
    ],
)
def test_values_are_matched_as_they_were_typed(where: dict, found: str):
    runs = [
        run("a", 0, k="0.02", periods="30", lengths="[]"),
        run("b", 1, k="0.10", periods="30", lengths="[2, 3]"),
        run("c", 2, periods="30", on="True"),
    ]
    assert "".join(each.run_id for each in chosen(runs, where)) == found


@pytest.mark.parametrize(
    ("where", "message"),
    [
        ({"k": [0.3, 0.4]}, r"k=0\.3,0\.4: no run has this value; there is 0\.02$"),
        ({"kay": 0.3}, r"kay: no such parameter of these runs; did you mean k\?"),
    ],
)
def test_a_value_or_parameter_that_no_run_has_is_refused(where: dict, message: str):
    with pytest.raises(ConfigError, match=message):
        chosen([run("a", 0, k="0.02")], where)


@pytest.mark.parametrize(
    ("where", "found"),
    [
        ({"curriculum.zero_shot": 0}, "a"),
        ({"curriculum.zero_shot": [0, 5]}, "ab"),
        ({"curriculum.epsilon": None}, "ab"),
        ({"task.precision": None}, "abcd"),
        ({"msa.until": "length"}, "b"),
    ],
)
def test_a_default_that_runs_leave_out_is_a_value_of_those_that_have_such_a_field(where: dict, found: str):
    runs = [
        run("a", 0, curriculum="coarse_to_fine"),
        run("b", 1, curriculum="new_goals", curriculum__zero_shot="5", msa="length_2"),
        run("c", 2),
        run("d", 3, curriculum="coarse_to_fine", curriculum__source="version 1"),  # a file of the user's of this name
    ]
    assert "".join(each.run_id for each in chosen(runs, where)) == found
