"""Links to the pages of MLflow's UI that show the recorded runs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from rl_design_space.errors import ConfigError
from rl_design_space.tracking.address import sqlite_path
from rl_design_space.tracking.connection import connect
from rl_design_space.tracking.view_state import VIEW_TAG, created_at
from rl_design_space.tracking.views import POINTS_KEY, STUDY_KEY, SWEEPS_KEY, link

if TYPE_CHECKING:
    from mlflow.entities import Experiment

    from rl_design_space.tracking.backends import MlflowTracking


@dataclass(frozen=True)
class UiPages:
    """The experiments of a store and their saved views.

    Attributes:
        points: id of the experiment that holds the design points.
        sweeps: id of the experiment that holds the summary runs of sweeps, if there is one.
        views: when the saved views of both were saved, in milliseconds since 1970, by their keys.
    """

    points: str
    sweeps: str | None
    views: Mapping[str, int]

    def first(self, address: str, study: str | None = None) -> str:
        """Return the address of a study; of that which was swept last if None, and of all points if there is none.

        Args:
            address: of the UI.
            study: its name.

        Raises:
            ConfigError: no sweep of the study was recorded.
        """
        studies = [key for key in self.views if key.startswith(STUDY_KEY)]
        if study is None:
            newest = max(studies, key=lambda key: self.views[key], default=self._known(POINTS_KEY))
            return link(address, self.points, newest)
        if (key := f"{STUDY_KEY}{study}") not in studies:
            known = ", ".join(sorted(each.removeprefix(STUDY_KEY) for each in studies)) or "none"
            raise ConfigError.at("study", study, f"no sweep of it is recorded here (there is {known})")
        return link(address, self.points, key)

    def links(self, address: str) -> Mapping[str, str]:
        """Return addresses by title: all points, each study that has a view, and all sweeps.

        Args:
            address: of the UI.
        """
        studies = sorted(key for key in self.views if key.startswith(STUDY_KEY))
        found = {"all design points": link(address, self.points, self._known(POINTS_KEY))}
        found |= {f"study {key.removeprefix(STUDY_KEY)}": link(address, self.points, key) for key in studies}
        if self.sweeps is not None:
            found["all sweeps"] = link(address, self.sweeps, self._known(SWEEPS_KEY))
        return found

    def _known(self, key: str) -> str:
        return key if key in self.views else ""


def find_pages(tracking: MlflowTracking) -> UiPages:
    """Find the pages of a store.

    Raises:
        ConfigError: nothing was recorded, or the store cannot be used.
        StoreUnavailableError: the store cannot be reached at the moment.
    """
    database = sqlite_path(tracking.uri)
    if database and not database.exists():
        raise ConfigError.at("tracking.uri", tracking.uri, "no run has been recorded there yet")
    client = connect(tracking.uri)
    points = client.get_experiment_by_name(tracking.experiment)
    sweeps = client.get_experiment_by_name(tracking.sweeps)
    if points is None:
        raise ConfigError.at(
            "tracking.experiment", tracking.experiment, f"there is no such experiment in {tracking.uri}"
        )
    views = _views(points) | (_views(sweeps) if sweeps else {})
    return UiPages(points.experiment_id, sweeps.experiment_id if sweeps else None, views)


def _views(experiment: Experiment) -> dict[str, int]:
    tags = experiment.tags.items()
    return {tag.removeprefix(VIEW_TAG): created_at(text) for tag, text in tags if tag.startswith(VIEW_TAG)}
