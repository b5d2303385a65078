"""The options of tracking."""

from __future__ import annotations

import pytest

from tests.command_runner import python


def imported_by(statements: str) -> set[str]:
    program = f"import sys\n{statements}\nprint(*sys.modules)"
    return {name.partition(".")[0] for name in python(program).split()}


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
