"""MLflow's client, configured before it is imported."""

from __future__ import annotations

import logging
import os
from typing import TYPE_CHECKING

from rl_design_space.tracking.address import mlflow_uri

if TYPE_CHECKING:
    from mlflow import MlflowClient


def configure_mlflow(patience: float = 30.0) -> None:
    """Configure MLflow through the environment, before it is imported; what the user has set there wins.

    Telemetry is off, a dead server is noticed within seconds, and MLflow logs nothing below a warning. Processes that
    this one starts inherit it.

    Args:
        patience: seconds to wait for a server that accepts a request and does not answer.
    """
    os.environ.setdefault("MLFLOW_DISABLE_TELEMETRY", "true")
    os.environ.setdefault("MLFLOW_HTTP_REQUEST_MAX_RETRIES", "2")
    # Each of the three attempts gets its share.
    os.environ.setdefault("MLFLOW_HTTP_REQUEST_TIMEOUT", str(max(round(patience / 3), 1)))
    os.environ.setdefault("MLFLOW_HTTP_REQUEST_BACKOFF_FACTOR", "1")
    os.environ.setdefault("MLFLOW_ENABLE_ARTIFACTS_PROGRESS_BAR", "false")
    os.environ.setdefault("MLFLOW_SUPPRESS_PRINTING_URL_TO_STDOUT", "true")
    for noisy, level in (("mlflow", logging.WARNING), ("alembic", logging.WARNING), ("urllib3", logging.ERROR)):
        logging.getLogger(noisy).setLevel(level)


def checked_client(uri: str) -> MlflowClient:
    """Return a client after a first request has succeeded, which creates or migrates the tables of a database.

    Raises:
        Exception: whatever MLflow raises.
    """
    configure_mlflow()
    from mlflow import MlflowClient

    client = MlflowClient(mlflow_uri(uri))
    client.search_experiments(max_results=1)
    return client
