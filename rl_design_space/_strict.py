"""How every option and setting is validated."""

from pydantic import ConfigDict

#: No unknown field, no silent conversion ("3" is not 3, true is not 1), no NaN, no infinity.
STRICT = ConfigDict(
    extra="forbid", strict=True, allow_inf_nan=False, validate_default=True, arbitrary_types_allowed=True
)
