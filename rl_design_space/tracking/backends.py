"""Where results are recorded, as chosen in conf/tracking. Nothing here imports MLflow until a tracker is opened."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Protocol, runtime_checkable

from pydantic import AfterValidator, Field, Strict
from pydantic.dataclasses import dataclass

from rl_design_space._strict import STRICT
from rl_design_space.errors import ConfigError, has_password
from rl_design_space.learning.measures import CURVES, CURVES_ON_DEMAND
from rl_design_space.learning.result import Kept
from rl_design_space.tracking.address import StoreAddress, absolute
from rl_design_space.tracking.tracker import NullTracker, Tracker

if TYPE_CHECKING:
    from rl_design_space.tracking.courier import Courier
    from rl_design_space.tracking.read import RunReader


def _known_curve(name: str) -> str:
    if name not in CURVES_ON_DEMAND:
        always = " (recorded anyway)" if name in CURVES else ""
        raise ValueError(f"should be among {', '.join(CURVES_ON_DEMAND)}{always}")
    return name


def _tracking_uri(uri: str) -> str:
    if has_password(uri):
        raise ValueError("should not hold a password; see docs/server.md for where it belongs")
    if not re.match(r"[a-z][a-z0-9+]*:", uri) or not uri.partition(":")[2].strip("/"):
        raise ValueError("should be a tracking URI such as sqlite:///FILE, postgresql://… or http://…")
    return uri


@runtime_checkable
class Tracking(Protocol):
    """A choice of where to record."""

    def open(self, command: str = "rl-design-space") -> Tracker:
        """Make ready to record.

        Args:
            command: that is recorded as the source of the runs.

        Raises:
            ConfigError: the store cannot be used.
        """
        ...

    def reader(self) -> RunReader:
        """Make ready to read what was recorded.

        Raises:
            ConfigError: there is nothing to read.
        """
        ...


@dataclass(frozen=True, kw_only=True, config=STRICT)
class MlflowTracking:
    """MLflow, by the URI of its tracking store.

    Attributes:
        uri: `sqlite:///path`, `postgresql://…`, `http://…`; without a password.
        experiment: name of the experiment that holds the design points.
        sweeps: name of the experiment that holds a summary run for each sweep.
        spool: folder that keeps results until the store has them.
        patience: seconds to wait for a store that takes nothing, before results are left to `rl-design-space sync`.
        curves: learning curves recorded beside those that always are.
        every: trials from one recorded value of a curve to the next.
        artifact: what the artifact of a run keeps: every trial of all periods and all curves, or the curves alone.
    """

    uri: Annotated[str, AfterValidator(_tracking_uri)]
    experiment: Annotated[str, Field(min_length=1)] = "design points"
    sweeps: Annotated[str, Field(min_length=1)] = "sweeps"
    spool: Annotated[str, Field(min_length=1)] = "outputs/spool"
    patience: Annotated[float, Field(gt=0)] = 30.0
    curves: Annotated[tuple[Annotated[str, AfterValidator(_known_curve)], ...], Strict(False)] = ()
    every: Annotated[int, Field(ge=1)] = 1
    artifact: Kept = "periods"

    @property
    def address(self) -> StoreAddress:
        """The store, from whatever folder."""
        return StoreAddress(absolute(self.uri), self.experiment, self.sweeps)

    def open(self, command: str = "rl-design-space", courier: Courier | None = None) -> Tracker:
        from rl_design_space.tracking.mlflow_tracker import MlflowTracker

        return MlflowTracker(
            self.address,
            Path(self.spool),
            command,
            location=f"{self.uri}, experiment {self.experiment!r}",
            patience=self.patience,
            curves=self.curves,
            every=self.every,
            keep=self.artifact,
            courier=courier,
        )

    def reader(self) -> RunReader:
        from rl_design_space.tracking.read import RunReader

        return RunReader(self.address)


@dataclass(frozen=True, kw_only=True, config=STRICT)
class NoTracking:
    """Nothing is recorded."""

    def open(self, command: str = "rl-design-space") -> Tracker:
        return NullTracker()

    def reader(self) -> RunReader:
        raise ConfigError("tracking=none: nothing was recorded, so there is nothing to read")
