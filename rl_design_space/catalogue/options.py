"""The options of a choice: what each is, and what it takes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import yaml
from omegaconf import DictConfig, OmegaConf

from rl_design_space.catalogue.comments import first_sentence, key_comments, leading_comment
from rl_design_space.catalogue.docstrings import docstring_of
from rl_design_space.catalogue.fields import Schema, schemas_of
from rl_design_space.catalogue.search import Search
from rl_design_space.config.build import build_component
from rl_design_space.config.compose import OPTION_GROUPS, Composer
from rl_design_space.config.explain import explain
from rl_design_space.config.target import imported
from rl_design_space.plan.planner import Planner

#: Stands for the default of a field that an option's file does not give.
NOT_GIVEN = object()


@dataclass(frozen=True)
class Parameter:
    """A value of an option or of the whole configuration.

    Attributes:
        name: as on the command line, `exploration.k`.
        schema: JSON Schema of its type and range; empty if anything goes.
        default: what the file says, or NOT_GIVEN.
        description: of the class's docstring, or else the file's comment; may be empty.
    """

    name: str
    schema: Schema
    default: Any
    description: str


@dataclass(frozen=True)
class Option:
    """An option of a choice, as its file and its class describe it.

    Attributes:
        group: the choice.
        name: of the option.
        summary: in a sentence.
        description: all that its file's comment, or else its class's docstring says.
        place: where its file lies.
        target: `_target_` of the class, if it names one.
        parameters: its values, in the order of the file.
        error: why it cannot be used; empty if it can.
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
        name: of the group.
        description: what is chosen.
        default: the option that is taken unless another one is named.
        options: without their parameters.
        points: how many each option has, or why it cannot be planned; None unless these are studies, and counted.
    """

    name: str
    description: str
    default: str | None
    options: Sequence[Option]
    points: Mapping[str, int | str] | None = None


class Options:
    """Describes options.

    Args:
        search: finds their files.
    """

    def __init__(self, search: Search) -> None:
        self._search = search
        self.planner = Planner(Composer(search.searchpath))

    def of_group(self, group: str, check: bool = True) -> list[Option]:
        """The options of a group, without their parameters.

        Args:
            group: the choice.
            check: whether each is built, to tell those that cannot be used.
        """
        found = []
        for name in self._search.options(group):
            path = f"{group}/{name}"
            said, error = leading_comment(self._search.text(path)), ""
            try:
                node = self._search.node(path)
                said = said or _said_of(group, node)
                if check:
                    self._build(group, name)
            except Exception as problem:
                error = in_words(problem)
            summary = first_sentence(" ".join(said.split()))
            found.append(Option(group, name, summary, said, self._search.place(path), error=error))
        return found

    def option(self, group: str, name: str) -> Option:
        """One option, with its parameters.

        Raises:
            ConfigError: there is no such option.
        """
        self._search.check(group, name)
        path = f"{group}/{name}"
        text, error, node = self._search.text(path), "", dict[str, Any]()
        comments: Mapping[str, str] = {}
        said, kind = leading_comment(text), None
        try:
            node = self._search.node(path) or {}
            comments = key_comments(text)
            node = self._composed(group, name)
            said = said or _said_of(group, node)
            kind = _class_of(group, node) if "_target_" in node else None
            self._build(group, name)
        except Exception as problem:
            error = in_words(problem)
        return Option(
            group,
            name,
            first_sentence(" ".join(said.split())),
            said,
            self._search.place(path),
            _target_of(node),
            tuple(parameters_of(group, node, kind, comments)),
            error,
        )

    def _composed(self, group: str, name: str) -> dict[str, Any]:
        """What choosing an option puts at its group, interpolations as they are written."""
        config = self.planner.composer.config([f"{group}={name}"])
        node = OmegaConf.select(config, group.replace("/", "."), throw_on_missing=False)
        found = OmegaConf.to_container(node) if isinstance(node, DictConfig) else {}
        return {str(key): value for key, value in found.items()} if isinstance(found, dict) else {}

    def _build(self, group: str, name: str) -> None:
        """Make sure that an option can be used.

        Raises:
            Exception: it cannot be, for whatever reason.
        """
        if group in OPTION_GROUPS:
            self.planner([f"{group}={name}"])
        elif group == "tracking":
            build_component(self.planner.composer.config([f"{group}={name}"]), group)


def parameters_of(
    prefix: str, node: Mapping[str, Any], kind: type | None, comments: Mapping[str, str]
) -> list[Parameter]:
    """The parameters of what a config file describes.

    Args:
        prefix: where its keys stand.
        node: its keys and values.
        kind: the class that they are for, if it is known.
        comments: on the keys.
    """
    try:
        schema = schemas_of({"": kind}).classes[""] if kind else {}
    except Exception:  # a class of a user's own that pydantic cannot read: its values are shown all the same
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
    """What a schema says of values, without the words."""
    return {name: value for name, value in schema.items() if name not in ("description", "default")}


def _said_of(group: str, node: Any) -> str:
    """Return the docstring of the class that an option names, without its sections; empty if it names none."""
    return docstring_of(_class_of(group, node)).text if _target_of(node) else ""


def _class_of(group: str, node: Any) -> type:
    return imported(f"{group.replace('/', '.')}._target_", _target_of(node))


def _target_of(node: Any) -> str:
    return str(node.get("_target_", "")) if isinstance(node, Mapping) else ""


def in_words(problem: Exception) -> str:
    """What is wrong with an option, in one line."""
    if isinstance(problem, yaml.YAMLError):
        return "not YAML: " + " ".join(str(problem).split())
    explained = explain(problem)
    return " ".join(str(explained or f"{type(problem).__name__}: {problem}").split())
