"""Values are printed as they are typed."""

from __future__ import annotations

from typing import Any

import pytest
import yaml
from hydra.core.override_parser.overrides_parser import OverridesParser

from rl_design_space._yaml import as_yaml

VALUES = [
    (None, "null"),
    (True, "true"),
    (0, "0"),
    ("x y", "x y"),
    ([1, [2.5]], "[1, [2.5]]"),
    ((2, 3), "[2, 3]"),
    ({"a": None, "b": [1]}, "{a: null, b: [1]}"),
    ([], "[]"),
    ({}, "{}"),
]


@pytest.mark.parametrize(("value", "typed"), VALUES)
def test_a_value_is_printed_as_it_is_typed(value: Any, typed: str):
    assert as_yaml(value) == typed


@pytest.mark.parametrize("value", [value for value, _ in VALUES if not isinstance(value, tuple)], ids=str)
def test_yaml_and_hydra_read_back_what_is_printed(value: Any):
    assert yaml.safe_load(as_yaml(value)) == value
    (override,) = OverridesParser.create().parse_overrides([f"key={as_yaml(value)}"])
    assert override.value() == value


def test_sweeps_stay_sweeps():
    assert as_yaml("10,20") == "10,20"
