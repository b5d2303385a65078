"""One composer a module: composing takes Hydra 0.1 s, and what is composed once is kept."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from rl_design_space.sweep.compose import Composer, shipped_config


@pytest.fixture(scope="module")
def composer() -> Iterator[Composer]:
    with shipped_config():
        yield Composer()
