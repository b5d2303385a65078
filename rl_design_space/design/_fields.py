"""What all options share: how they are validated, and the array types that they produce."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import ConfigDict

#: Validation of every option: no unknown field, no silent conversion ("3" is not 3, true is not 1), no NaN.
STRICT = ConfigDict(
    extra="forbid", strict=True, allow_inf_nan=False, validate_default=True, arbitrary_types_allowed=True
)

IntArray = NDArray[np.integer[Any]]
FloatArray = NDArray[np.float64]
