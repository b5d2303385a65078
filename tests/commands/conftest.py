"""A user config folder with valid and invalid files, and subcommands run in this process."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from rl_design_space.commands import words
from rl_design_space.commands.terminal import console

OWN_MODULE = '''
from dataclasses import dataclass
from typing import Annotated
import numpy as np
from pydantic import Field
from rl_design_space.design import cell_count


@dataclass(frozen=True)
class Near:
    """Whether the due goal is near.

    Attributes:
        radius: cells within which it is.
    """

    radius: Annotated[int, Field(ge=1)] = 2

    def observation(self, world, goals):
        return np.zeros((*goals.shape, cell_count(world)), dtype=np.int64)


def function():
    pass
'''

FILES = {
    "representation/near.yaml": "_target_: own_parts.Near\nradius: 3\n",
    "representation/commented.yaml": "# My own one, as it is. More.\n_target_: own_parts.Near\nradius: 3\n",
    "representation/child.yaml": "# Built on another.\ndefaults: [direction, _self_]\nrule: horizontal_first\n",
    "representation/not_yaml.yaml": "# Not even YAML.\n_target_: [own_parts.Near\n",
    "representation/nowhere.yaml": "_target_: nowhere.Near\n",
    "representation/raises.yaml": "# Raises.\n_target_: own_raises.Near\n",
    "representation/function.yaml": "_target_: own_parts.function\n",
    "representation/misspelt.yaml": "# Misspelt.\n_target_: rl_design_space.design.Direction\nruel: x\n",
    "representation/open.yaml": "# To be filled in.\n_target_: own_parts.Near\nradius: ???\n",
    "exploration/steep.yaml": "# [bold]Steep[/bold].\n_target_: rl_design_space.design.Linear\nstart: 1.5\n",
    "study/mine.yaml": """\
# A study of one's own. With more.
blocks:
  small: {world.size: "4,5", msa: "none,length_5"}
  again: {world.size: 4}
constraints:
  goes_round: {drop: "max(msa.lengths, default=1) > min(world.shape)", why: the move goes all the way round}
""",
    "study/wrong.yaml": "# A wrong one.\nblocks: {small: {world.size: 0}}\n",
    "study/both.yaml": "# Two.\nincludes: [table4, mine]\n",
    "experiment/first.yaml": "# @package _global_\n# An experiment.\ndefaults: [{override /world: walled}]\nseed: 5\n",
}


@pytest.fixture
def own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Create a config folder whose components can be imported."""
    folder = tmp_path / "it's mine"
    for name, text in FILES.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text, encoding="utf-8")
    (tmp_path / "own_parts.py").write_text(OWN_MODULE, encoding="utf-8")
    (tmp_path / "own_raises.py").write_text("raise RuntimeError('not today')\n", encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    return folder


@pytest.fixture
def said(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> Callable[..., str]:
    """Run a subcommand and return its output, with columns one space apart."""
    monkeypatch.setattr(console, "_width", 300)

    def run(word: str, *arguments: str) -> str:
        words.run(word, arguments)
        lines = [" ".join(line.split()) for line in capsys.readouterr().out.splitlines()]
        return "\n".join(filter(None, lines))

    return run


@pytest.fixture
def told(capsys: pytest.CaptureFixture[str]) -> Callable[..., Any]:
    """Run a subcommand with `--json` and return its output."""

    def run(word: str, *arguments: str) -> Any:
        words.run(word, [*arguments, "--json"])
        return json.loads(capsys.readouterr().out)

    return run
