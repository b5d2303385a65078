"""The pages of MLflow's UI that there are for what has been recorded."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from rl_design_space.errors import ConfigError
from rl_design_space.tracking.address import sqlite_path
from rl_design_space.tracking.connection import connect
from rl_design_space.tracking.store_errors import StoreUnavailableError
from rl_design_space.tracking.view_state import VIEW_TAG
from rl_design_space.tracking.views import POINTS_KEY, STUDY_KEY, SWEEPS_KEY, link

if TYPE_CHECKING:
    from mlflow.entities import Experiment

    from rl_design_space.tracking.backends import MlflowTracking


@dataclass(frozen=True)
class Pages:
    """The experiments of a store and the saved views that they have.

    Attributes:
        points: id of the experiment that holds the design points.
        sweeps: id of the one that holds the sweeps' summary runs, if there is one.
        views: keys of the saved views of either.
    """

    points: str
    sweeps: str | None
    views: frozenset[str]

    def links(self, address: str) -> Mapping[str, str]:
        """The addresses of the pages by what they show: all points, each study that has a view, and all sweeps."""
        studies = sorted(key for key in self.views if key.startswith(STUDY_KEY))
        found = {"all design points": link(address, self.points, self._known(POINTS_KEY))}
        found |= {f"study {key.removeprefix(STUDY_KEY)}": link(address, self.points, key) for key in studies}
        if self.sweeps is not None:
            found["all sweeps"] = link(address, self.sweeps, self._known(SWEEPS_KEY))
        return found

    def _known(self, key: str) -> str:
        return key if key in self.views else ""


def pages(tracking: MlflowTracking) -> Pages:
    """Look which pages there are.

    Raises:
        ConfigError: nothing was recorded, or the store cannot be used.
    """
    database = sqlite_path(tracking.uri)
    if database and not database.exists():
        raise ConfigError.at("tracking.uri", tracking.uri, "no run has been recorded there yet")
    try:
        client = connect(tracking.uri)
        points = client.get_experiment_by_name(tracking.experiment)
        sweeps = client.get_experiment_by_name(tracking.sweeps)
    except StoreUnavailableError as error:
        raise ConfigError.at("tracking.uri", tracking.uri, f"cannot be reached at the moment: {error}") from error
    if points is None:
        raise ConfigError.at(
            "tracking.experiment", tracking.experiment, f"there is no such experiment in {tracking.uri}"
        )
    views = _views(points) | (_views(sweeps) if sweeps else frozenset())
    return Pages(points.experiment_id, sweeps.experiment_id if sweeps else None, views)


def _views(experiment: Experiment) -> frozenset[str]:
    return frozenset(tag.removeprefix(VIEW_TAG) for tag in experiment.tags if tag.startswith(VIEW_TAG))
