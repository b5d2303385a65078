"""Measures of the user's own: Python functions that are named by module and function.

A function whose first argument is called `periods` returns a number for each period; one whose first argument is called
`curves` is given curves of steps / optimum and returns a number for each of them.
"""

from __future__ import annotations

import inspect
from collections.abc import Mapping
from pkgutil import resolve_name
from traceback import extract_tb
from types import FunctionType
from typing import Any

import numpy as np

from rl_design_space._arrays import FloatArray
from rl_design_space.errors import ConfigError
from rl_design_space.learning.measure_kinds import CurveMeasure, Measure, PeriodMeasure, Periods

_EXPECTED = "should be a function whose first argument is called periods or curves"


def own_measure(name: str, parameters: Mapping[str, Any]) -> Measure:
    """Return the measure that a function computes.

    Args:
        name: module and function, as in `my_module.my_measure`.
        parameters: arguments of the function after the first one.

    Raises:
        ConfigError: there is no such function, or it has not these parameters.
    """
    function = _imported(name)
    first = _first_argument(name, function, parameters)
    what = (inspect.getdoc(function) or name).partition("\n")[0].rstrip(".").replace("{", "{{").replace("}", "}}")
    if first == "periods":
        return PeriodMeasure(what.format(), lambda periods: _of_periods(name, function, parameters, periods))
    return CurveMeasure(
        f"{what}, of the {{}} curve", lambda curves: _called(name, function, parameters, curves, curves.shape[:-1])
    )


def _imported(name: str) -> FunctionType:
    try:
        function = resolve_name(name)
    except Exception as error:  # a module may raise anything when it is imported
        raise ConfigError(f"measure {name}: cannot be imported: {error}") from error
    if not isinstance(function, FunctionType):
        raise ConfigError.at("measure", name, _EXPECTED)
    return function


def _first_argument(name: str, function: FunctionType, parameters: Mapping[str, Any]) -> str:
    """Return the name of the first argument of a function.

    Raises:
        ConfigError: it is another one, or the function has not these parameters.
    """
    signature = inspect.signature(function)
    first = next(iter(signature.parameters), "")
    if first not in ("periods", "curves"):
        raise ConfigError.at("measure", name, _EXPECTED)
    known = list(signature.parameters)[1:]
    for parameter in parameters:
        if parameter not in known:
            raise ConfigError(f"measure {name}: {ConfigError.unknown('parameter', parameter, known)}")
    try:
        signature.bind(None, **parameters)
    except TypeError as error:
        raise ConfigError(f"measure {name}: {error}") from error
    return first


def _of_periods(name: str, function: FunctionType, parameters: Mapping[str, Any], periods: Periods) -> FloatArray:
    return _called(name, function, parameters, periods, periods.steps.shape[:1])


def _called(
    name: str, function: FunctionType, parameters: Mapping[str, Any], data: object, shape: tuple[int, ...]
) -> FloatArray:
    """Return what a function computes.

    Raises:
        ConfigError: it raises an error, or returns anything but finite numbers of this shape.
    """
    try:
        values = np.asarray(function(data, **parameters))
    except ConfigError:
        raise
    except Exception as error:  # the function may raise anything
        own = [each for each in extract_tb(error.__traceback__) if each.filename == function.__code__.co_filename]
        place = (own or extract_tb(error.__traceback__))[-1]
        reason = " ".join(f"{type(error).__name__}: {error}".split())
        raise ConfigError(f"measure {name}: {reason} ({place.filename}:{place.lineno})") from error
    if values.dtype.kind not in "biuf" or values.shape != shape:
        raise ConfigError(f"measure {name}: should return numbers of shape {shape}, not {values.dtype} {values.shape}")
    if not np.isfinite(values).all():
        bad = int((~np.isfinite(values)).sum())
        raise ConfigError(f"measure {name}: {bad} of its {values.size} numbers are NaN or infinite")
    return values.astype(np.float64)
