"""Points recorded as a first attempt would, with MLflow's fluent API: `python -m benchmarks.naive DATABASE POINTS`."""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path
from tempfile import TemporaryDirectory

import rl_design_space as rds
from rl_design_space.learning.measures import CURVES
from rl_design_space.plan.describe import resolved_config
from rl_design_space.plan.planner import plan_point
from rl_design_space.tracking.content import config_file, periods_file
from rl_design_space.tracking.mlflow_client import configure_mlflow
from rl_design_space.tracking.record import params


def main() -> None:
    """Record the same of one point again and again; the CPU seconds of it as JSON."""
    configure_mlflow()
    import mlflow

    planned = plan_point()
    curves = rds.simulate(planned.point)
    config = resolved_config(planned.point)
    mlflow.set_tracking_uri(f"sqlite:///{sys.argv[1]}")
    place = Path(sys.argv[1]).parent / "artifacts"
    mlflow.set_experiment(experiment_id=mlflow.create_experiment("points", artifact_location=place.as_uri()))
    started = time.process_time()
    for _ in range(int(sys.argv[2])):
        with mlflow.start_run():
            for name, value in params(planned.parameters).items():
                mlflow.log_param(name, value)
            for name, number in curves.scalars().items():
                mlflow.log_metric(name, number)
            for name in CURVES:
                for trial, number in enumerate(curves.curves[name].tolist()):
                    mlflow.log_metric(name, number, step=trial)
            with TemporaryDirectory() as folder:
                files = {"config.yaml": config_file(planned.command, config), "periods.npz": periods_file(curves)}
                for file, content in files.items():
                    (Path(folder) / file).write_bytes(content)
                    mlflow.log_artifact(str(Path(folder) / file))
    print(json.dumps({"cpu": time.process_time() - started}))


if __name__ == "__main__":
    main()
