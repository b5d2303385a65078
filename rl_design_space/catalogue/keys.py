"""The keys of the whole configuration: choices, the task, the seed, and the settings of runs and sweeps."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import Any

from rl_design_space.catalogue.comments import key_comments
from rl_design_space.catalogue.docstrings import docstring_of
from rl_design_space.catalogue.fields import Schema, schemas_of
from rl_design_space.catalogue.options import NOT_GIVEN, Parameter, constraints_only, parameters_of
from rl_design_space.catalogue.search import Search
from rl_design_space.config.compose import CONFIG_NAME
from rl_design_space.config.overrides import SETTINGS
from rl_design_space.config.target import imported
from rl_design_space.design import DesignPoint
from rl_design_space.run.settings import Settings


class Keys:
    """Descriptions of the keys of the primary config.

    Args:
        search: where to find its file.
    """

    def __init__(self, search: Search) -> None:
        self._search = search

    @cached_property
    def names(self) -> tuple[str, ...]:
        """All keys except those of Hydra, choices first."""
        known = [*docstring_of(DesignPoint).fields, *SETTINGS]
        return tuple(dict.fromkeys(key for key in (*self._search.groups, *known) if key != "hydra"))

    def description(self, key: str) -> str:
        """Return the description of a key, from the config file or else from its class; empty if there is none."""
        documented = {**docstring_of(DesignPoint).fields, **docstring_of(Settings).fields}
        return self._comments.get(key) or documented.get(key) or self._comments.get(f"defaults.{key}", "")

    def parameter(self, key: str) -> Parameter:
        """Return a key that holds one value."""
        schema = constraints_only(self._schemas.get(key, {}))
        return Parameter(key, schema, self._node.get(key, NOT_GIVEN), self.description(key))

    def parameters(self, key: str) -> list[Parameter]:
        """Return the parameters of a key that is not a choice: those of the component in it, or the key itself."""
        node = self._node.get(key)
        if not isinstance(node, Mapping) or "_target_" not in node:
            return [self.parameter(key)]
        comments = {name.removeprefix(f"{key}."): text for name, text in self._comments.items()}
        return parameters_of(key, node, imported(f"{key}._target_", node["_target_"]), comments)

    def target(self, key: str) -> str:
        """Return the `_target_` of the component that a key holds."""
        return str(self._node[key]["_target_"])

    @cached_property
    def _node(self) -> Mapping[str, Any]:
        return dict(self._search.node(CONFIG_NAME))

    @cached_property
    def _comments(self) -> Mapping[str, str]:
        return key_comments(self._search.text(CONFIG_NAME))

    @cached_property
    def _schemas(self) -> Mapping[str, Schema]:
        both = schemas_of({"point": DesignPoint, "settings": Settings}).classes
        return {**both["point"]["properties"], **both["settings"]["properties"]}
