"""MLflow's environment variables are honoured with `tracking=server`; otherwise it is said what is used instead."""

from __future__ import annotations

import pytest

from rl_design_space.commands.unused_variables import tell_of_unused_variables
from rl_design_space.errors import ConfigError
from rl_design_space.run.settings import settings_of
from rl_design_space.tracking import MlflowTracking


@pytest.fixture
def variables(monkeypatch: pytest.MonkeyPatch) -> pytest.MonkeyPatch:
    monkeypatch.setenv("MLFLOW_TRACKING_URI", "http://host:8080")
    monkeypatch.setenv("MLFLOW_EXPERIMENT_NAME", "mine")
    monkeypatch.delenv("MLFLOW_EXPERIMENT_ID", raising=False)
    return monkeypatch


def store(*overrides: str) -> tuple[str, str]:
    tracking = settings_of(overrides).tracking
    assert isinstance(tracking, MlflowTracking)
    tell_of_unused_variables(tracking)
    return tracking.uri, tracking.experiment


def test_a_server_and_its_experiment_are_those_of_the_variables(
    variables: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    assert store("tracking=server") == ("http://host:8080", "mine")
    assert capsys.readouterr().err == ""


def test_a_variable_that_is_not_used_is_named_once_with_what_is_used_instead(
    variables: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    variables.setenv("MLFLOW_TRACKING_URI", "http://ada:secret@host:8080")
    variables.setenv("MLFLOW_EXPERIMENT_ID", "7")
    assert store() == ("sqlite:///outputs/mlflow.db", "design points")
    first, second, third = capsys.readouterr().err.splitlines()
    assert first == (
        "MLFLOW_TRACKING_URI=http://…@host:8080 is not used, but tracking.uri=sqlite:///outputs/mlflow.db; "
        "tracking=server uses it, unless tracking.uri is given"
    )
    assert second.startswith("MLFLOW_EXPERIMENT_NAME=mine is not used, but tracking.experiment=design points;")
    assert third == "MLFLOW_EXPERIMENT_ID=7 is not used, but tracking.experiment=design points"


def test_a_password_in_the_variable_is_refused(variables: pytest.MonkeyPatch):
    variables.setenv("MLFLOW_TRACKING_URI", "http://ada:secret@host:8080")
    with pytest.raises(ConfigError, match=r"^tracking.uri=http://…@host:8080: should not hold a password"):
        settings_of(["tracking=server"])


def test_without_variables_a_server_is_on_this_machine(variables: pytest.MonkeyPatch):
    variables.delenv("MLFLOW_TRACKING_URI")
    variables.delenv("MLFLOW_EXPERIMENT_NAME")
    assert store("tracking=server") == ("http://127.0.0.1:5000", "design points")
