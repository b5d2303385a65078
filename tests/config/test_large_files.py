"""Config files that are too large are refused before Hydra copies their values."""

from __future__ import annotations

from pathlib import Path

import pytest

from rl_design_space.config import user_config
from rl_design_space.config.compose import Composer, shipped_config
from rl_design_space.errors import ConfigError
from tests.config.test_yaml_limits import BOMB


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (BOMB, "describes more than 100,000 values"),
        ("[" * 10_000, "more than 40 collections inside each other"),
        (f"size: {'9' * 5000}", "cannot be read: Exceeds the limit"),
        ("size: !!timestamp 2020-99-99", "cannot be read: month must be in 1..12"),
    ],
    ids=["bomb", "deep", "number", "date"],
)
def test_a_config_file_that_is_too_large_is_named(
    text: str, message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.chdir(tmp_path)
    file = tmp_path / "conf" / "world" / "mine.yaml"
    file.parent.mkdir(parents=True)
    file.write_text(text)
    with user_config.used("conf"), shipped_config():
        composer = Composer()
        with pytest.raises(ConfigError, match=r"^conf/world/mine\.yaml: ") as caught:
            composer.parts(["world=mine"])
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)
