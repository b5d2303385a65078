"""The options of `tracking=…`: where results are recorded. MLflow is not imported before it is needed."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from pydantic import AfterValidator, Field, Strict
from pydantic.dataclasses import dataclass
from typing_extensions import Protocol, runtime_checkable

from rl_design_space._paths import expanded, why_unwritable
from rl_design_space._strict import STRICT
from rl_design_space.config.measure_name import ValueName
from rl_design_space.errors import ConfigError
from rl_design_space.learning.measures import CURVES, CURVES_ON_DEMAND
from rl_design_space.learning.result import Kept
from rl_design_space.tracking.address import StoreAddress, absolute, checked_uri
from rl_design_space.tracking.tracker import NullTracker, Tracker

if TYPE_CHECKING:
    from rl_design_space.tracking.background import BackgroundDelivery
    from rl_design_space.tracking.read import RunReader


def _known_curve(name: str) -> str:
    if name not in CURVES_ON_DEMAND:
        always = " (recorded anyway)" if name in CURVES else ""
        raise ValueError(f"should be among {', '.join(CURVES_ON_DEMAND)}{always}")
    return name


@runtime_checkable
class Tracking(Protocol):
    """An option of `tracking=…`."""

    def open(self, command: str = "rl-design-space") -> Tracker:
        """Return a tracker.

        Args:
            command: recorded as the source of the runs.

        Raises:
            ConfigError: the store cannot be used.
        """
        ...

    def reader(self) -> RunReader:
        """Return a reader of the recorded runs.

        Raises:
            ConfigError: nothing was recorded.
        """
        ...


@dataclass(frozen=True, kw_only=True, config=STRICT)
class MlflowTracking:
    """Recording in an MLflow tracking store.

    Attributes:
        uri: URI of the store: `sqlite:///path`, `postgresql://…`, `http://…`; without a password or token.
        experiment: name of the experiment that holds the design points.
        sweeps: name of the experiment that holds a summary run for each sweep.
        spool: folder of the pending records: results that are not in the store yet.
        patience: seconds to wait for a store that accepts nothing, before results are left to `rl-design-space sync`.
        curves: names of learning curves to record in addition to those that always are.
        every: number of trials from one recorded value of a curve to the next.
        artifact: what the artifact of a run holds: every trial of all periods and all curves, or the curves alone.
        leaderboard: measures in the note and the leaderboard of a sweep; points are ranked by the first.
    """

    uri: Annotated[str, AfterValidator(checked_uri)]
    experiment: Annotated[str, Field(min_length=1)] = "design points"
    sweeps: Annotated[str, Field(min_length=1)] = "sweeps"
    spool: Annotated[str, Field(min_length=1), AfterValidator(expanded)] = "outputs/spool"
    patience: Annotated[float, Field(gt=0)] = 30.0
    curves: Annotated[tuple[Annotated[str, AfterValidator(_known_curve)], ...], Strict(False)] = ()
    every: Annotated[int, Field(ge=1)] = 1
    artifact: Kept = "periods"
    leaderboard: Annotated[tuple[ValueName, ...], Strict(False), Field(min_length=1)] = ("total_steps",)

    @property
    def address(self) -> StoreAddress:
        """The store, by a URI that is valid in any working directory."""
        return StoreAddress(absolute(self.uri), self.experiment, self.sweeps)

    def open(self, command: str = "rl-design-space", delivery: BackgroundDelivery | None = None) -> Tracker:
        from rl_design_space.tracking.mlflow_client import configure_mlflow
        from rl_design_space.tracking.mlflow_tracker import MlflowTracker
        from rl_design_space.tracking.read_only import not_writable
        from rl_design_space.tracking.schema import check_schema

        if reason := why_unwritable(spools := Path(self.spool)):
            raise not_writable(spools, reason)
        configure_mlflow(self.patience)
        check_schema(self.address)
        return MlflowTracker(
            self.address,
            spools,
            command,
            location=f"{self.uri}, experiment {self.experiment!r}",
            patience=self.patience,
            curves=self.curves,
            every=self.every,
            keep=self.artifact,
            leaderboard=self.leaderboard,
            delivery=delivery,
        )

    def reader(self) -> RunReader:
        from rl_design_space.tracking.read import RunReader

        return RunReader(self.address)


def seconds_to_record(tracking: Tracking) -> float:
    """Return approximately how many seconds of a core it takes to record a point (docs/performance.md)."""
    if isinstance(tracking, NoTracking):
        return 0.0
    return 0.1 if isinstance(tracking, MlflowTracking) and tracking.address.is_server else 0.012


@dataclass(frozen=True, kw_only=True, config=STRICT)
class NoTracking:
    """Recording nothing."""

    def open(self, command: str = "rl-design-space") -> Tracker:
        return NullTracker()

    def reader(self) -> RunReader:
        raise ConfigError("tracking=none: nothing was recorded, so there is nothing to read")
