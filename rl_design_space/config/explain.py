"""Translate errors of Hydra, OmegaConf, pydantic and PyYAML into messages that name the key and the value."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from contextlib import contextmanager

from hydra.errors import ConfigCompositionException, HydraException, MissingConfigException, OverrideParseException
from omegaconf import DictConfig
from omegaconf.errors import (
    ConfigAttributeError,
    ConfigKeyError,
    MissingMandatoryValue,
    OmegaConfBaseException,
)
from pydantic import ValidationError
from pydantic_core import ErrorDetails
from yaml import MarkedYAMLError, YAMLError, safe_load

from rl_design_space.config import user_config
from rl_design_space.errors import ConfigError

_HIDDEN_KEYS = {"_target_", "hydra"}


def explain(error: Exception) -> ConfigError | None:
    """Translate an error into a `ConfigError`; return None if it does not concern the configuration."""
    if isinstance(error, ConfigError):
        return error
    if isinstance(error, MissingConfigException) and error.missing_cfg_file:
        group, _, option = str(error.missing_cfg_file).rpartition("/")
        return unknown_option(group, option, error.options or ())
    if isinstance(error, OverrideParseException):
        return ConfigError(f"{error.override}: not an override; overrides look like key=value, e.g. exploration.k=0.02")
    if isinstance(error, ConfigCompositionException) and isinstance(
        error.__cause__, (ConfigAttributeError, ConfigKeyError)
    ):
        return unknown_key(error.__cause__)
    if isinstance(error, (ConfigAttributeError, ConfigKeyError)):
        return unknown_key(error)
    if isinstance(error, MissingMandatoryValue):
        return ConfigError.at(str(error.full_key), "???", "needs a value")
    if isinstance(error, OmegaConfBaseException) and error.full_key:
        return ConfigError(f"{error.full_key}: {str(error).splitlines()[0]}")
    if isinstance(error, MarkedYAMLError):
        return _not_yaml(error)
    if isinstance(error, OSError) and error.filename:
        return ConfigError(f"{error.filename}: {error.strerror}; outputs=DIR writes elsewhere")
    if ambiguous := re.match(r"Ambiguous value for argument '(.*)'", str(error)):
        return ConfigError(f"{ambiguous[1]}: several values make a sweep; add -m to run them all")
    if isinstance(error, (HydraException, OmegaConfBaseException)):
        return ConfigError(" ".join(str(error).split()))
    return None


@contextmanager
def explained() -> Iterator[None]:
    """Translate errors that concern the configuration into `ConfigError`."""
    try:
        yield
    except ConfigError:
        raise
    except Exception as error:
        if translated := explain(error):
            raise translated from error
        raise


def _not_yaml(error: MarkedYAMLError) -> ConfigError:
    """Return an error with the place of a YAML error, and where the faulty block starts: parsers notice it later."""
    mark = error.problem_mark or error.context_mark
    context = f" {error.context}" if error.context else ""
    begun = f" that begins in line {error.context_mark.line + 1}" if context and error.context_mark else ""
    place = f"{mark.name}:{mark.line + 1}:{mark.column + 1}" if mark else "YAML"
    return ConfigError(f"{place}: {error.problem}{context}{begun}")


def unknown_option(group: str, option: str, known: Iterable[str]) -> ConfigError:
    """Return an error for an unknown option, with a config folder that has it, or else the most similar option."""
    if folder := user_config.unused(group, option):
        needed = f"{user_config.FLAG} {user_config.shown(folder)}"
        return ConfigError.at(group, option, f"no such option; {needed} would add it")
    return ConfigError.unknown("option", option, known, prefix=f"{group}=")


def unknown_key(error: ConfigAttributeError | ConfigKeyError) -> ConfigError:
    """Return an error for an unknown key, with the most similar key of the composed config."""
    parent, _, key = str(error.full_key).rpartition(".")
    siblings = error.parent_node if isinstance(error.parent_node, DictConfig) else {}
    known = [str(name) for name in siblings if name not in _HIDDEN_KEYS]
    option = str(siblings.get("_target_", "")).rpartition(".")[2]
    return ConfigError.unknown(f"key in {option}" if option else "key", key, known, f"{parent}." if parent else "")


def invalid(prefix: str, error: ValidationError, known: list[str]) -> ConfigError:
    """Return an error for the fields of one choice that pydantic refused."""
    lines = []
    for detail in error.errors(include_url=False):
        key = ".".join(str(part) for part in (prefix, *detail["loc"]) if part != "")
        if detail["type"] == "unexpected_keyword_argument":
            lines.append(str(ConfigError.unknown("key", str(detail["loc"][-1]), known, f"{prefix}.")))
        elif not detail["loc"]:
            lines.append(_plain(detail["msg"]))
        elif _needs_a_number(detail) and _is_quoted(detail["input"]):
            remedy = "write it without quotes, or ${oc.decode:${oc.env:NAME}} for an environment variable"
            lines.append(f'{key}="{detail["input"]}": {_plain(detail["msg"])}, not text; {remedy}')
        else:
            lines.append(str(ConfigError.at(key, detail["input"], _plain(detail["msg"]))))
    return ConfigError("\n".join(lines))


def _needs_a_number(detail: ErrorDetails) -> bool:
    return detail["type"] in ("int_type", "float_type", "bool_type") or "number" in detail["msg"]


def _is_quoted(value: object) -> bool:
    """Return whether a value is text that would be a number, true or false without quotes."""
    if not isinstance(value, str):
        return False
    try:
        return isinstance(safe_load(value), (int, float))
    except YAMLError:
        return False


def _plain(message: str) -> str:
    return re.sub(r"^(Input |Value error, |Assertion failed, )", "", message)
