"""One choice with all its options."""

from __future__ import annotations

from rl_design_space.catalogue.keys import Keys
from rl_design_space.catalogue.options import Choice, Options
from rl_design_space.catalogue.search import HYDRA_GROUPS, Search
from rl_design_space.catalogue.studies import count_points
from rl_design_space.errors import ConfigError


def choice(search: Search, options: Options, group: str, counted: bool = False) -> Choice:
    """Return the description of a choice and its options.

    Args:
        search: where to find their files.
        options: describes the options.
        group: name of the choice.
        counted: whether to count the points of studies, which plans each of them.

    Raises:
        ConfigError: the choice does not exist.
    """
    known = (*search.groups, *HYDRA_GROUPS)
    if group not in known:
        raise ConfigError.unknown("choice", group, known)
    found = options.of_group(group)
    points = None
    if group == "study" and counted:
        points = {option.name: count_points(options.planner, option.name) for option in found}
    return Choice(group, Keys(search).description(group), search.defaults.get(group), found, points)
