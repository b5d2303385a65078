"""A `_target_` names a class that can be imported."""

from __future__ import annotations

import pytest

from rl_design_space.config.target import imported
from rl_design_space.errors import ConfigError


@pytest.mark.parametrize("path", ["nowhere.Class", "json.nothing", "json.dumps", "json", "", "not a path", "a..b", 3])
def test_anything_else_is_refused(path: object):
    with pytest.raises(ConfigError, match=r"^world\._target_="):
        imported("world._target_", path)


def test_a_class_is_imported_by_either_spelling():
    assert (
        imported("x", "json.JSONDecoder")
        is imported("x", "json:JSONDecoder")
        is imported("x", "json.decoder.JSONDecoder")
    )
