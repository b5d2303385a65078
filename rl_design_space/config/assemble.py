"""Assemble points from overrides without composing each one: every option is read once and reused."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import deepcopy
from dataclasses import fields
from typing import Any, NamedTuple

from hydra.core.default_element import GroupDefault
from hydra.core.override_parser.overrides_parser import OverridesParser
from hydra.core.override_parser.types import ValueType
from hydra.errors import HydraException
from hydra.plugins.config_source import ConfigResult
from omegaconf import OmegaConf

from rl_design_space.config.build import build
from rl_design_space.config.overrides import ABSENT, ABSENT_OPTION, SETTINGS, is_setting
from rl_design_space.config.stage_options import CURRICULUM, check_stages
from rl_design_space.design import DesignPoint
from rl_design_space.errors import ConfigError

#: Values that only a whole config can resolve.
_UNRESOLVED = ("${", "???")
_FIELDS = tuple(field.name for field in fields(DesignPoint))


class Parts(NamedTuple):
    """The parts of a point: the built value of each of its fields, and the names of the chosen options."""

    values: Mapping[str, Any]
    options: Mapping[str, str]


class _NotPlainError(Exception):
    """The point cannot be assembled; Hydra has to compose it."""


class _Choice(NamedTuple):
    group: str
    option: str


class _Value(NamedTuple):
    field: str
    path: tuple[str, ...]
    value: Any


class Assembler:
    """Assembles the parts of points from options and values where the result equals what Hydra composes.

    That is the case where every option file is plain: it stays in its own group, has no defaults list, and neither
    files nor overrides interpolate. Nor may the primary config have other files than options in its defaults list. All
    other points are left to Hydra.

    Args:
        repository: Hydra's repository of config files.
        primary: name of the primary config.
        defaults: the composed primary config, with its choices.
        groups: config groups that are design choices.
        parser: parses overrides.
    """

    def __init__(
        self, repository: Any, primary: str, defaults: Any, groups: Sequence[str], parser: OverridesParser
    ) -> None:
        self._repository = repository
        self._groups = frozenset(groups)
        self._parser = parser
        choices = defaults.hydra.runtime.choices
        # A primary config of the user's own may leave out choices that have a value for their absence.
        self._absent = {group: value for group, value in ABSENT.items() if group not in defaults}
        self._options = {group: str(choices.get(group, ABSENT_OPTION)) for group in groups}
        rest = [field for field in _FIELDS if field not in self._groups]
        self._rest: Any = OmegaConf.to_container(OmegaConf.masked_copy(defaults, rest))
        self._parsed: dict[str, _Choice | _Value | None] = {}
        self._nodes: dict[tuple[str, str], dict[str, Any] | None] = {}
        self._components: dict[tuple[str, ...], Any] = {}
        self._shared: dict[tuple[str, ...], Mapping[str, str]] = {}
        self._usable = self._is_plain(repository.load_config(primary), defaults)

    def __call__(self, overrides: Sequence[str]) -> Parts | None:
        """Return the parts that these overrides describe, or None if Hydra has to compose them or report an error."""
        if not self._usable:
            return None
        try:
            return self._assemble(overrides)
        except (_NotPlainError, ConfigError, HydraException):
            return None

    def _is_plain(self, primary: ConfigResult, defaults: Any) -> bool:
        """Return whether nothing but its file contributes to an option: neither the primary config nor another file."""
        choices = defaults.hydra.runtime.choices
        files: list[Any] = [file for file in primary.defaults_list or () if not file.is_self()]
        return (
            not self._groups & set(primary.config)
            and set(defaults) <= {*_FIELDS, *SETTINGS}
            and all(isinstance(file, GroupDefault) or self._only_chooses(file.path) for file in files)
            and all(group in self._groups or is_setting(f"{group}=") for group in choices)
            and not any(
                file_reaches_out(self._repository, f"{group}/{choices.get(group)}") for group in ("tracking", "study")
            )
            and all(
                self._node(group, option) == OmegaConf.to_container(defaults[group])
                for group, option in self._options.items()
                if group not in self._absent
            )
        )

    def _only_chooses(self, path: str) -> bool:
        """Return whether a config file has no content but overrides of options."""
        found = self._repository.load_config(path)
        return not found.config and all(default.is_override() for default in found.defaults_list or ())

    def _assemble(self, overrides: Sequence[str]) -> Parts:
        options, values = dict(self._options), dict[str, list[str]]()
        for override in overrides:
            parsed = self._parse(override)
            if isinstance(parsed, _Choice):
                options[parsed.group] = parsed.option
            elif parsed:
                values.setdefault(parsed.field, []).append(override)
        built = {field: self._component(field, options.get(field), values.get(field, ())) for field in _FIELDS}
        check_stages(options[CURRICULUM], built[CURRICULUM])
        return Parts(built, self._shared.setdefault(tuple(options.values()), options))

    def _parse(self, override: str) -> _Choice | _Value | None:
        """Return what an override changes in a point; None if it is a setting."""
        if override not in self._parsed:
            if is_setting(override):
                self._check_setting(override)
            self._parsed[override] = None if is_setting(override) else self._parse_new(override)
        return self._parsed[override]

    def _check_setting(self, text: str) -> None:
        """Leave settings to Hydra that choose a file which also changes the point."""
        override = self._parser.parse_override(text)
        if file_reaches_out(self._repository, f"{override.key_or_group}/{override.value()}"):
            raise _NotPlainError

    def _parse_new(self, text: str) -> _Choice | _Value:
        override = self._parser.parse_override(text)
        plain = override.type.name == "CHANGE" and override.value_type == ValueType.ELEMENT and not override.package
        value = override.value() if plain else None
        if not plain or any(mark in str(value) for mark in _UNRESOLVED):  # not in the text, where they may be escaped
            raise _NotPlainError
        field, *path = override.key_or_group.split(".")
        if not path and field in self._groups:
            if not isinstance(value, str) or not value or field in self._absent:
                raise _NotPlainError
            return _Choice(field, value)
        if field not in _FIELDS or isinstance(value, dict):
            raise _NotPlainError
        return _Value(field, tuple(path), value)

    def _component(self, field: str, option: str | None, overrides: Sequence[str]) -> Any:
        """Return the value of a field; equal values are one object, which saves memory with thousands of points."""
        if field in self._absent and not overrides:
            return self._absent[field]
        key = (field, option or "", *overrides)
        if key not in self._components:
            node = self._node(field, option) if option else self._rest[field]
            if node is None:
                raise _NotPlainError
            holder = {field: deepcopy(node)}
            for override in overrides:
                _put(holder, self._parsed[override])
            self._components[key] = build(field, holder[field])
        return self._components[key]

    def _node(self, group: str, option: str) -> dict[str, Any] | None:
        """Return the content of an option's file, or None if choosing the option means more than that."""
        if (group, option) not in self._nodes:
            self._nodes[group, option] = self._load(f"{group}/{option}")
        return self._nodes[group, option]

    def _load(self, path: str) -> dict[str, Any] | None:
        if not self._repository.config_exists(path):
            return None
        found = self._repository.load_config(path)
        node: Any = OmegaConf.to_container(found.config)
        plain = not reaches_out(found) and isinstance(node, dict)
        return node if plain and not any(mark in str(node) for mark in _UNRESOLVED) else None


def file_reaches_out(repository: Any, path: str) -> bool:
    """Return whether there is a config file at a path, and choosing it may change something outside its group."""
    return repository.config_exists(path) and reaches_out(repository.load_config(path))


def reaches_out(found: ConfigResult) -> bool:
    """Return whether choosing a config file may change something outside its group."""
    listed = [default for default in found.defaults_list or () if not default.is_self()]
    return bool(listed or found.header.get("package"))


def _put(node: dict[str, Any], value: _Choice | _Value | None) -> None:
    """Replace an existing value."""
    assert isinstance(value, _Value)
    *parents, last = (value.field, *value.path)
    inner: Any = node
    for name in parents:
        inner = inner.get(name) if isinstance(inner, dict) else None
    if not isinstance(inner, dict) or last not in inner or isinstance(inner[last], dict):
        raise _NotPlainError
    inner[last] = value.value
