"""Translate errors of Hydra, OmegaConf, pydantic and PyYAML into messages that name the key and the value."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import fields
from typing import TYPE_CHECKING, Any, get_type_hints

from hydra.errors import ConfigCompositionException, HydraException, MissingConfigException, OverrideParseException
from omegaconf import DictConfig
from omegaconf.errors import (
    ConfigAttributeError,
    ConfigKeyError,
    MissingMandatoryValue,
    OmegaConfBaseException,
)
from pydantic import ValidationError
from yaml import MarkedYAMLError, YAMLError, safe_load

from rl_design_space._yaml import as_yaml
from rl_design_space.config import user_config
from rl_design_space.config.grammar import not_understood
from rl_design_space.config.overrides import is_setting
from rl_design_space.config.target import class_of
from rl_design_space.design.identity import full_name
from rl_design_space.design.lacking import NO_INSTANCE, lacking
from rl_design_space.errors import ConfigError

if TYPE_CHECKING:
    from pydantic_core import ErrorDetails

#: Numbers that YAML 1.1 reads in base 8, 16 or 60; on the command line they are text.
_OTHER_NUMBER = re.compile(r"[-+]?(0\d+|0x[\da-fA-F]+|\d+(:\d+)+)")

#: Options that come with another package, by what to install.
_EXTRAS = {
    ("hydra/sweeper", "optuna"): "rl-design-space[optuna]",
    ("hydra/launcher", "joblib"): "hydra-joblib-launcher",
    ("hydra/launcher", "submitit_slurm"): "hydra-submitit-launcher",
    ("hydra/launcher", "submitit_local"): "hydra-submitit-launcher",
}
#: What pydantic calls a value that should be a single one.
_SCALAR = ("int_type", "float_type", "bool_type", "string_type")
_HIDDEN_KEYS = {"_target_", "hydra"}


def explain(error: Exception) -> ConfigError | None:
    """Translate an error into a `ConfigError`; return None if it does not concern the configuration."""
    if isinstance(error, ConfigError):
        return error
    if isinstance(error, MissingConfigException) and error.missing_cfg_file:
        group, _, option = str(error.missing_cfg_file).rpartition("/")
        return unknown_option(group, option, error.options or ())
    if isinstance(error, OverrideParseException):
        return not_understood(error.override)
    if isinstance(error, ConfigCompositionException) and isinstance(
        error.__cause__, (ConfigAttributeError, ConfigKeyError)
    ):
        return unknown_key(error.__cause__)
    if isinstance(error, ConfigCompositionException) and isinstance(error.__cause__, OmegaConfBaseException):
        return explain(error.__cause__)
    if isinstance(error, (ConfigAttributeError, ConfigKeyError)):
        return unknown_key(error)
    if isinstance(error, MissingMandatoryValue):
        return ConfigError.at(str(error.full_key), "???", "needs a value")
    if isinstance(error, OmegaConfBaseException) and error.full_key:
        return ConfigError(f"{error.full_key}: {str(error).splitlines()[0]}")
    if isinstance(error, YAMLError):
        return _not_yaml(error)
    if isinstance(error, OSError) and error.filename:
        return ConfigError(f"{error.filename}: {error.strerror}; outputs=DIR writes elsewhere")
    if ambiguous := re.match(r"Ambiguous value for argument '(.*)'", str(error)):
        return ConfigError(f"{ambiguous[1]}: several values make a sweep; add -m to run them all")
    if isinstance(error, (HydraException, OmegaConfBaseException)) and str(error).strip():
        return ConfigError(" ".join(str(error).split()))
    if _raised_by_hydra(error):
        reason = " ".join(f"{type(error).__name__}: {error}".removesuffix(": ").split())
        return ConfigError(f"Hydra cannot use these arguments or files ({reason}); HYDRA_FULL_ERROR=1 shows where")
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


def _raised_by_hydra(error: Exception) -> bool:
    """Return whether Hydra or OmegaConf raised an error, instead of one of their own for what cannot be composed."""
    trace = error.__traceback__
    while trace and trace.tb_next:
        trace = trace.tb_next
    if trace is None or trace.tb_frame.f_code.co_name == "return_value":  # Hydra passes on the error of a job
        return False
    module: str = trace.tb_frame.f_globals.get("__name__", "")
    return module.partition(".")[0] in ("hydra", "omegaconf", "antlr4", "yaml")


def _not_yaml(error: YAMLError) -> ConfigError:
    """Return an error with the place of a YAML error, and where the faulty block starts: parsers notice it later."""
    if not isinstance(error, MarkedYAMLError):
        return ConfigError(" ".join(str(error).split()))
    mark = error.problem_mark or error.context_mark
    context = f" {error.context}" if error.context else ""
    begun = f" that begins in line {error.context_mark.line + 1}" if context and error.context_mark else ""
    place = f"{mark.name}:{mark.line + 1}:{mark.column + 1}" if mark else "YAML"
    return ConfigError(f"{place}: {error.problem}{context}{begun}")


def unknown_option(group: str, option: str, known: Iterable[str]) -> ConfigError:
    """Return an error for an unknown option, with a config folder that has it, or else the most similar option."""
    if not group:
        return ConfigError(f"{option}: there is no such config file")
    if extra := _EXTRAS.get((group, option)):
        return ConfigError.at(group, option, f"not installed; pip install '{extra}' adds it")
    if folder := user_config.unused(group, option):
        needed = f"{user_config.FLAG} {user_config.shown(folder)}"
        return ConfigError.at(group, option, f"no such option; {needed} would add it")
    return ConfigError.unknown("option", option, known, prefix=f"{group}=")


def unknown_key(error: ConfigAttributeError | ConfigKeyError) -> ConfigError:
    """Return an error for an unknown key, with the most similar key of the composed config."""
    parent, _, key = str(error.full_key).rpartition(".")
    siblings = error.parent_node if isinstance(error.parent_node, DictConfig) else {}
    known = [str(name) for name in siblings if name not in _HIDDEN_KEYS]
    target = str(siblings.get("_target_", ""))
    option = target.rpartition(".")[2]
    if key not in known and key in _fields_of(parent, target):
        return ConfigError(
            f"{error.full_key}: a field of {option} that the file of this option does not list; "
            f"+{error.full_key}=VALUE sets it, or list it there"
        )
    return ConfigError.unknown(f"key in {option}" if option else "key", key, known, f"{parent}." if parent else "")


def _fields_of(key: str, target: str) -> list[str]:
    """Return the names of the fields of the class that an option names; none if there is no such class."""
    try:
        return [field.name for field in fields(class_of(key, target)) if field.init] if target else []
    except ConfigError:
        return []


def invalid(prefix: str, error: ValidationError, kind: Any, values: Mapping[str, Any]) -> ConfigError:
    """Return an error for the fields of a validated dataclass that pydantic refused, and the values it was given."""
    known = [field.name for field in fields(kind)]
    lines = []
    for detail in _joined(error.errors(include_url=False), values):
        key = ".".join(str(part) for part in (prefix, *detail["loc"]) if part != "")
        if detail["type"] == "unexpected_keyword_argument":
            lines.append(str(ConfigError.unknown("key", str(detail["loc"][-1]), known, f"{prefix}.")))
        elif detail["type"].startswith("missing"):  # its input is not the value of the field, but all arguments
            lines.append(str(ConfigError.at(key, "???", "needs a value")))
        elif not detail["loc"]:
            lines.append(_plain(detail["msg"]))
        elif isinstance(detail.get("ctx", {}).get("error"), ConfigError):  # which names key and value itself
            lines.append(f"{key}: {_plain(detail['msg'])}")
        elif detail["type"] == NO_INSTANCE and (missing := _lacking(kind, detail)):
            expected = _plain(detail["msg"]).removesuffix(f"; it has no {missing}")
            lines.append(f"{key}={full_name(type(detail['input']))}: {expected}; it has no {missing}")
        elif isinstance(detail["input"], list) and detail["type"] in _SCALAR and not is_setting(f"{key}="):
            swept = ",".join(map(as_yaml, detail["input"]))
            remedy = f'values without brackets make a sweep: {key}={swept}, in a file {key}: "{swept}"'
            lines.append(str(ConfigError.at(key, detail["input"], f"{_plain(detail['msg'])}, not a list; {remedy}")))
        elif _needs_a_number(detail) and _is_quoted(detail["input"]):
            remedy = "write it without quotes, or ${oc.decode:${oc.env:NAME}} for an environment variable"
            if _OTHER_NUMBER.fullmatch(detail["input"]):
                remedy = "numbers are decimal, without leading zeros, colons and letters"
            lines.append(f'{key}="{detail["input"]}": {_plain(detail["msg"])}, not text; {remedy}')
        else:
            lines.append(str(ConfigError.at(key, detail["input"], _plain(detail["msg"]))))
    return ConfigError("\n".join(lines))


def _joined(details: Iterable[ErrorDetails], values: Mapping[str, Any]) -> list[ErrorDetails]:
    """Return one error for all alternatives of a field, at the place of a value in the config.

    Pydantic tries one alternative after the other and adds its name to the place. If the value has the type of one of
    them, nothing is said of the others.
    """
    found: dict[tuple[int | str, ...], list[ErrorDetails]] = {}
    for detail in details:
        place = _place(detail["loc"], values)
        found.setdefault(place, []).append(detail | {"loc": place, "msg": _without_tuples(detail)})
    joined = []
    for place, several in found.items():
        is_entered = any(len(other) > len(place) and other[: len(place)] == place for other in found)
        if is_entered and all(detail["type"].endswith("_type") for detail in several):
            continue
        apt = [detail for detail in several if not detail["type"].endswith("_type")] or several
        joined.append(apt[0] | {"msg": "; or ".join(dict.fromkeys(_plain(detail["msg"]) for detail in apt))})
    return joined


def _place(loc: Sequence[int | str], values: Any) -> tuple[int | str, ...]:
    """Return the parts of pydantic's place that are keys and numbers, not names of validators and alternatives."""
    place = []
    for depth, part in enumerate(loc):
        is_key = isinstance(values, Mapping) and part in values
        if depth == 0 or is_key or isinstance(part, int):
            place.append(part)
            values = values[part] if is_key or _has(values, part) else None
    return tuple(place)


def _has(values: Any, part: int | str) -> bool:
    return isinstance(values, Sequence) and isinstance(part, int) and part < len(values)


def _without_tuples(detail: ErrorDetails) -> str:
    """Return a message that asks for a list where pydantic asks for a tuple, which YAML does not have."""
    if detail["type"] != "tuple_type":
        return detail["msg"]
    value = detail["input"]
    is_example = isinstance(value, (int, float, str)) and not isinstance(value, bool)
    return f"should be a list{f', such as [{as_yaml(value)}]' if is_example else ''}"


def _lacking(kind: Any, detail: ErrorDetails) -> str:
    """Return what a component does not have of its protocol; empty if that is not what is wrong with it."""
    return lacking(get_type_hints(kind).get(str(detail["loc"][0])), detail["input"])


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
    message = re.sub(r"^(Input |Value error, |Assertion failed, |(Tuple|List) (?=should have))", "", message)
    return message.replace(" after validation,", ",")
