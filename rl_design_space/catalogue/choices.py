"""The choices there are."""

from __future__ import annotations

from rl_design_space.catalogue.keys import Keys
from rl_design_space.catalogue.options import Choice, Options
from rl_design_space.catalogue.search import HYDRA_GROUPS, Search
from rl_design_space.catalogue.studies import count_points
from rl_design_space.errors import ConfigError


def choice(search: Search, options: Options, group: str, counted: bool = False) -> Choice:
    """Describe a choice and its options.

    Args:
        search: finds their files.
        options: describes them.
        group: the choice.
        counted: whether to count the points of studies, which takes a moment.

    Raises:
        ConfigError: there is no such choice.
    """
    known = (*search.groups, *HYDRA_GROUPS)
    if group not in known:
        raise ConfigError.unknown("choice", group, known)
    found = options.of_group(group)
    points = None
    if group == "study" and counted:
        points = {option.name: count_points(options.planner, option.name) for option in found}
    return Choice(group, Keys(search).description(group), search.defaults.get(group), found, points)
