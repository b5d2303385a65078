"""What a component does not have of the protocol of its choice."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import is_dataclass
from inspect import isfunction
from typing import Any

from pydantic import ValidationError, WrapValidator
from pydantic_core import PydanticCustomError

#: Type of pydantic's error about a value of another class.
NO_INSTANCE = "is_instance_of"


def lacking(protocol: Any, component: Any) -> str:
    """Return the members of a protocol that a component does not have; empty if that is not what is wrong with it."""
    if not getattr(protocol, "_is_protocol", False) or not is_dataclass(component):
        return ""
    bases = [base for base in protocol.__mro__ if getattr(base, "_is_protocol", False)]
    declared = sorted({name for base in bases for name in vars(base) if not name.startswith("_")})
    missing = [name for name in declared if not hasattr(component, name)]
    return ", ".join(f"{name}()" if isfunction(getattr(protocol, name)) else name for name in missing)


def component_of(protocol: Any) -> WrapValidator:
    """Return the validator of a field that holds a component: a class or a name is refused, and what lacks members."""

    def validated(option: Any, handler: Callable[[Any], Any]) -> Any:
        if isinstance(option, type):
            raise ValueError(f"should be built: {option.__name__}(…), not the class itself")
        if isinstance(option, str):
            raise ValueError("should be built, as Direction() or Linear(k=0.02) are; names are for from_overrides()")
        try:
            return handler(option)
        except ValidationError as error:
            if not (missing := lacking(protocol, option)):
                raise
            told = {"protocol": protocol.__name__, "missing": missing}
            message = "Input should be an instance of {protocol}; it has no {missing}"
            raise PydanticCustomError(NO_INSTANCE, message, told) from error

    return WrapValidator(validated)
