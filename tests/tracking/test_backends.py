"""The options of tracking."""

from __future__ import annotations

import subprocess
import sys

import pytest


def imported_by(statements: str) -> set[str]:
    program = f"import sys\n{statements}\nprint(*sys.modules)"
    output = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True).stdout
    return {name.partition(".")[0] for name in output.split()}


@pytest.mark.parametrize(
    "statements",
    [
        "import rl_design_space.tracking",
        "from rl_design_space.tracking import NoTracking; NoTracking().open()",
        "from rl_design_space.tracking import MlflowTracking; MlflowTracking(uri='sqlite:///x.db')",
    ],
)
def test_options_and_null_tracker_do_not_import_mlflow(statements: str):
    assert not {"mlflow", "sqlalchemy", "pandas"} & imported_by(statements)
