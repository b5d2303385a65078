"""List all choices with their options, or one choice; of studies also the number of points."""

from __future__ import annotations

import json
from collections.abc import Sequence

from rl_design_space.commands.arguments import Parser
from rl_design_space.commands.lookup import question
from rl_design_space.errors import ConfigError

_MORE = "rl-design-space show CHOICE=OPTION describes one option"
_MORE_OF_ALL = "rl-design-space list study counts points"


def main(arguments: Sequence[str]) -> None:
    """Print options with their descriptions.

    Raises:
        ConfigError: the choice does not exist.
    """
    parser = Parser(
        prog="rl-design-space list",
        description="List all choices with their options, or one choice; of studies also the number of points.",
        epilog="examples: rl-design-space list; rl-design-space list representation; rl-design-space list study",
    )
    asked = question(parser, arguments, "[CHOICE]", "one choice, such as representation, study, hydra/launcher")
    if others := [override for override in asked.overrides if override not in asked.searchpath]:
        raise ConfigError(
            f"{others[0]}: list accepts no override except hydra.searchpath; "
            f"use `rl-design-space show study=NAME {others[0]}`"
        )
    from rl_design_space.catalogue.choices import choice
    from rl_design_space.catalogue.options import Options
    from rl_design_space.catalogue.search import searched

    with searched(asked.config_dir, asked.searchpath) as search:
        options, one = Options(search), asked.subject is not None
        groups = (asked.subject,) if asked.subject else search.groups
        choices = [choice(search, options, group, counted=one) for group in groups]
    if asked.json:
        from rl_design_space.catalogue.records import choice_record

        print(json.dumps({each.name: choice_record(each) for each in choices}, indent=2, ensure_ascii=False))
        return
    from rl_design_space.commands.catalogue_tables import choice_table
    from rl_design_space.commands.terminal import console

    console.print(choice_table(choices))
    console.print(_MORE if one else f"{_MORE}; {_MORE_OF_ALL}", markup=False, soft_wrap=True)
