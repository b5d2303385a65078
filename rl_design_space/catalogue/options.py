"""The options of a choice: their descriptions and parameters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any

import yaml
from omegaconf import DictConfig, OmegaConf

from rl_design_space.catalogue.comments import first_sentence, key_comments, leading_comment
from rl_design_space.catalogue.docstrings import docstring_of
from rl_design_space.catalogue.fields import Schema, schemas_of
from rl_design_space.catalogue.search import Search
from rl_design_space.config.build import build_component
from rl_design_space.config.compose import Composer
from rl_design_space.config.explain import explain
from rl_design_space.config.overrides import OPTION_GROUPS
from rl_design_space.config.target import imported
from rl_design_space.errors import ConfigError
from rl_design_space.plan.planner import Planner

#: Default of a field that the file of an option does not give.
NOT_GIVEN = object()


@dataclass(frozen=True)
class Parameter:
    """A parameter of an option or of the whole configuration.

    Attributes:
        name: key on the command line, e.g. `exploration.k`.
        schema: JSON Schema of its type and range; empty if every value is allowed.
        default: value in the file, or NOT_GIVEN.
        description: from the docstring of the class, or else from the comment in the file; may be empty.
    """

    name: str
    schema: Schema
    default: Any
    description: str


@dataclass(frozen=True)
class Option:
    """An option of a choice, described by its file and its class.

    Attributes:
        group: name of the choice.
        name: name of the option.
        summary: first sentence of the description.
        description: leading comment of its file, or else docstring of its class.
        place: path of its file.
        target: `_target_` of its class; empty if it has none.
        parameters: its parameters, in the order of the file.
        error: why the option cannot be used; empty if it can.
    """

    group: str
    name: str
    summary: str
    description: str
    place: str
    target: str = ""
    parameters: tuple[Parameter, ...] = field(default=())
    error: str = ""


@dataclass(frozen=True)
class Choice:
    """A config group.

    Attributes:
        name: name of the group.
        description: description of the group.
        default: the option used by default.
        options: its options, without their parameters.
        points: number of points of each study, or why it cannot be planned; None unless studies were counted.
    """

    name: str
    description: str
    default: str | None
    options: Sequence[Option]
    points: Mapping[str, int | str] | None = None


class Options:
    """Descriptions of options.

    Args:
        search: where to find their files.
    """

    def __init__(self, search: Search) -> None:
        self._search = search
        self.planner = Planner(Composer(search.searchpath))

    def of_group(self, group: str) -> list[Option]:
        """Return the options of a group, without their parameters; each is built, to find those that cannot be used."""
        found = []
        for name in self._search.options(group):
            path = f"{group}/{name}"
            description, error = leading_comment(self._search.text(path)), ""
            try:
                node = self._search.node(path)
                description = description or _docstring(group, node)
                self._build(group, name)
            except Exception as problem:
                error = in_words(problem)
            summary = first_sentence(" ".join(description.split()))
            found.append(Option(group, name, summary, description, self._search.place(path), error=error))
        return found

    def option(self, group: str, name: str) -> Option:
        """Return an option with its parameters.

        Raises:
            ConfigError: the option does not exist.
        """
        self._search.check(group, name)
        path = f"{group}/{name}"
        text, error, node = self._search.text(path), "", dict[str, Any]()
        comments: Mapping[str, str] = {}
        description, kind = leading_comment(text), None
        try:
            node = self._search.node(path) or {}
            comments = key_comments(text)
            node = self._composed(group, name)
            description = description or _docstring(group, node)
            kind = _class_of(group, node) if "_target_" in node else None
            self._build(group, name)
        except Exception as problem:
            error = in_words(problem)
        return Option(
            group,
            name,
            first_sentence(" ".join(description.split())),
            description,
            self._search.place(path),
            _target_of(node),
            tuple(parameters_of(group, node, kind, comments)),
            error,
        )

    def _composed(self, group: str, name: str) -> dict[str, Any]:
        """Return the composed config of an option, with interpolations unresolved."""
        config = self.planner.composer.config([f"{group}={name}"])
        node = OmegaConf.select(config, group.replace("/", "."), throw_on_missing=False)
        found = OmegaConf.to_container(node) if isinstance(node, DictConfig) else {}
        return {str(key): value for key, value in found.items()} if isinstance(found, dict) else {}

    def _build(self, group: str, name: str) -> None:
        """Build an option, to check that it can be used.

        Raises:
            Exception: the option cannot be used; of any kind, because a user's own class may raise any.
        """
        if group in OPTION_GROUPS:
            self._build_point(f"{group}={name}")
        elif group == "tracking":
            build_component(self.planner.composer.config([f"{group}={name}"]), group)

    def _build_point(self, override: str) -> None:
        """Build a point with an option; with another representation if it cannot be used with the default one."""
        try:
            self.planner([override])
        except ConfigError:
            others = () if override.startswith("representation=") else self._search.options("representation")
            for other in others:
                with suppress(ConfigError):
                    self.planner([override, f"representation={other}"])
                    return
            raise


def parameters_of(
    prefix: str, node: Mapping[str, Any], kind: type | None, comments: Mapping[str, str]
) -> list[Parameter]:
    """Return the parameters of a component.

    Args:
        prefix: config group or key of the component.
        node: its keys and values in the config file.
        kind: its class, if known.
        comments: comments in the config file, by key.
    """
    try:
        schema = schemas_of({"": kind}).classes[""] if kind else {}
    except Exception:  # pydantic cannot read a user's own class: its values are shown without types
        schema = {}
    properties = schema.get("properties", {})
    names = dict.fromkeys([*(key for key in node if key != "_target_"), *properties])
    return [
        Parameter(
            f"{prefix.replace('/', '.')}.{name}",
            constraints_only(properties.get(name, {})),
            node.get(name, NOT_GIVEN),
            properties.get(name, {}).get("description") or comments.get(name, ""),
        )
        for name in names
    ]


def constraints_only(schema: Schema) -> Schema:
    """Return a schema without description and default."""
    return {name: value for name, value in schema.items() if name not in ("description", "default")}


def _docstring(group: str, node: Any) -> str:
    """Return the docstring of the class that an option names, without its sections; empty if it names none."""
    return docstring_of(_class_of(group, node)).text if _target_of(node) else ""


def _class_of(group: str, node: Any) -> type:
    return imported(f"{group.replace('/', '.')}._target_", _target_of(node))


def _target_of(node: Any) -> str:
    return str(node.get("_target_", "")) if isinstance(node, Mapping) else ""


def in_words(problem: Exception) -> str:
    """Return an error as one line of text."""
    if isinstance(problem, yaml.YAMLError):
        return "not YAML: " + " ".join(str(problem).split())
    explained = explain(problem)
    return " ".join(str(explained or f"{type(problem).__name__}: {problem}").split())
