"""Options built without Hydra where it would pass their values on."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import pytest

from rl_design_space.config import build as module
from rl_design_space.config.build import build

HERE = f"{__name__}"


@dataclass(frozen=True)
class Held:
    """An option that holds any value."""

    value: Any = None


@dataclass(frozen=True)
class Builder(Held):
    """An option that builds the options inside of it."""

    builds_options: ClassVar[bool] = True


INNER = {"_target_": f"{HERE}.Held", "value": 1}


@pytest.mark.parametrize("value", [3, "text", None, [1, [2, "x"]], {"a": {"b": [True]}, 2: 0.5}, (1, (2,))])
def test_plain_values_are_passed_on_as_hydra_does(value: object, monkeypatch: pytest.MonkeyPatch):
    node = {"_target_": f"{HERE}.Held", "value": value}
    with monkeypatch.context() as without:
        without.setattr(module, "_is_simple", lambda value, may_have_options: False)
        expected = build("study.report", node)
    monkeypatch.setattr(module, "instantiate", None)
    built = build("study.report", node)
    assert built == expected
    assert built.value is not value or not isinstance(value, (dict, list))


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        (INNER, Held(1)),
        ([{"a": INNER}], [{"a": Held(1)}]),
        ("${oc.decode:'7'}", 7),
        ({"_target_": "builtins.dict", "_convert_": "all", "a": 1}, {"a": 1}),
    ],
)
def test_everything_else_goes_through_hydra(value: object, expected: object):
    assert build("study.report", {"_target_": f"{HERE}.Held", "value": value}).value == expected


def test_an_option_that_builds_its_options_gets_them_as_they_are_written(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(module, "instantiate", None)
    assert build("study.report", {"_target_": f"{HERE}.Builder", "value": [INNER]}).value == [INNER]
