"""Names of measures in configs."""

from __future__ import annotations

import pytest

from rl_design_space.config.measure_name import with_own_measures
from rl_design_space.errors import ConfigError

OWN = {"_target_": "no_such_module.late", "share": 0.25}


def test_own_measures_are_named_wherever_they_are_and_are_not_imported():
    part = {"_target_": "some.Part", "measure": OWN, "point": {"value": 3}}
    node = {"_target_": "some.Report", "value": OWN, "claims": {"a": {"parts": [part, {"measure": "total_steps"}]}}}
    assert with_own_measures(node) == {
        "_target_": "some.Report",
        "value": "no_such_module.late,share=0.25",
        "claims": {
            "a": {
                "parts": [
                    {"_target_": "some.Part", "measure": "no_such_module.late,share=0.25", "point": {"value": 3}},
                    {"measure": "total_steps"},
                ]
            }
        },
    }
    assert with_own_measures({"measures": [OWN, "roughness"]}) == {
        "measures": ["no_such_module.late,share=0.25", "roughness"]
    }
    assert with_own_measures({"value": {"steps_after": 30}}) == {"value": {"steps_after": 30}}


def test_a_wrong_parameter_is_named():
    with pytest.raises(ConfigError, match=r"measure=\[1\]: a parameter should be a number"):
        with_own_measures({"value": {"_target_": "mine.late", "share": [1]}})
