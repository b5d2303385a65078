"""What the records of each kind contain."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from rl_design_space.learning.result import Kept
from rl_design_space.tracking.spool import CLOSE, OPEN, POINT, STUDIES, TIDY, CorruptedRecordError, Record

_Texts = dict[str, str]
_Number = Annotated[float, Field(allow_inf_nan=False)]
_Time = Annotated[int, Field(ge=0, lt=2**53)]


class _Content(BaseModel):
    # Other versions may have other keys besides.
    model_config = ConfigDict(extra="ignore", strict=True)


class _Run(_Content):
    name: str
    started: _Time
    tags: _Texts


class _Point(_Run):
    fingerprint: str = ""
    ended: _Time = 0
    seconds: float
    params: _Texts
    command: str
    config: dict[str, Any]
    scalars: dict[str, _Number]
    curves: list[str]
    every: Annotated[int, Field(ge=1)]
    keep: Kept


class _Opening(_Run):
    views: _Texts
    sweep_views: _Texts


class _Closing(_Run):
    ended: _Time
    status: str
    note: str
    metrics: list[Annotated[list[str | int | float], Field(min_length=3, max_length=3)]]


class _Studies(_Content):
    tags: dict[str, _Texts]


_SCHEMAS: dict[str, type[_Content]] = {
    OPEN: _Opening,
    POINT: _Point,
    STUDIES: _Studies,
    CLOSE: _Closing,
    TIDY: _Content,
}


def checked(record: Record) -> Record:
    """Return a record after a check of its content.

    Raises:
        CorruptedRecordError: a value is missing, or it is of another type than it should be.
    """
    try:
        _SCHEMAS[record.kind].model_validate(record.content)
    except ValidationError as error:
        first = error.errors(include_url=False, include_context=False)[0]
        key = ".".join(map(str, first["loc"]))
        raise CorruptedRecordError(record.name, f"record is corrupted ({key}: {first['msg']})") from error
    return record
