"""Show an option with its parameters, a study with its points, or a key with type, range and default."""

from __future__ import annotations

import json
from collections.abc import Sequence

from rl_design_space.commands.arguments import Parser
from rl_design_space.commands.lookup import question

_ABOUT = (
    "CHOICE=OPTION, study=NAME, CHOICE, a key such as seed, task, exploration.k, "
    "or schemas for the JSON Schemas of config files"
)


def main(arguments: Sequence[str]) -> None:
    """Print the description of an option, study, choice or key.

    Raises:
        ConfigError: the subject does not exist.
    """
    parser = Parser(
        prog="rl-design-space show",
        description="Show an option with its parameters, a study with its points, or a key.",
        epilog="examples: rl-design-space show exploration=linear; rl-design-space show study=table4 world.size=10,15; "
        "rl-design-space show task",
    )
    asked = question(parser, arguments, "SUBJECT", _ABOUT)
    from rl_design_space.catalogue.search import searched
    from rl_design_space.commands.answers import answer

    assert asked.subject is not None
    of_points = [override for override in asked.overrides if override not in asked.searchpath]
    with searched(asked.config_dir, asked.searchpath) as search:
        found = answer(search, asked.subject, of_points)
    if asked.json:
        print(json.dumps(found.record, indent=2, ensure_ascii=False))
        return
    from rl_design_space.commands.terminal import console

    for part in found.parts:
        # Lines are not wrapped, so that paths in them can be copied; paragraphs and tables fit the window.
        console.print(part, markup=False, soft_wrap=isinstance(part, str))
