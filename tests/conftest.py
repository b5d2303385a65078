"""What all tests share."""

from __future__ import annotations

import os

import pytest

from tests.servers import _shared_mlflow_server, auth_server, mlflow_server, postgres  # noqa: F401  (fixtures)


@pytest.hookimpl(trylast=True)
def pytest_sessionfinish(session: pytest.Session) -> None:
    """A test may skip where a service is missing on somebody's machine; in CI a skip is a failure."""
    reporter = session.config.pluginmanager.get_plugin("terminalreporter")
    if os.environ.get("CI") and reporter is not None and reporter.stats.get("skipped"):
        reporter.write_line("In CI nothing may be skipped.", red=True)
        session.exitstatus = pytest.ExitCode.TESTS_FAILED
