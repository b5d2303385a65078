"""MLflow's environment variables that a command does not use."""

from __future__ import annotations

import os

from rl_design_space._secrets import without_secrets
from rl_design_space.commands.messages import tell
from rl_design_space.tracking import MlflowTracking, Tracking


def tell_of_unused_variables(tracking: Tracking) -> None:
    """Print to stderr which variables that name another store or experiment are set, and what is used instead."""
    if not isinstance(tracking, MlflowTracking):
        return
    used = {
        "MLFLOW_TRACKING_URI": ("tracking.uri", tracking.uri),
        "MLFLOW_EXPERIMENT_NAME": ("tracking.experiment", tracking.experiment),
        "MLFLOW_EXPERIMENT_ID": ("tracking.experiment", tracking.experiment),
    }
    for name, (key, value) in used.items():
        given = os.environ.get(name)
        if given and given != value:
            remedy = "" if name.endswith("_ID") else f"; tracking=server uses it, unless {key} is given"
            tell(f"{name}={without_secrets(given)} is not used, but {key}={value}{remedy}")
