"""Errors of stores: which are transient, which are about access."""

from __future__ import annotations

import pytest

from rl_design_space.errors import ConfigError
from rl_design_space.tracking.store_errors import StoreUnavailableError, access_error, as_tracking_error, is_transient


def response_error(status: int) -> Exception:
    """Return the error that a server's response to an upload raises."""
    import requests

    response = requests.Response()
    response.status_code = status
    return requests.HTTPError(f"{status}", response=response)


@pytest.mark.parametrize("status", [401, 403])
def test_denied_access_is_not_transient(status: int):
    assert not is_transient(response_error(status))
    assert isinstance(as_tracking_error("http://host", response_error(status)), ConfigError)


@pytest.mark.parametrize("status", [429, 500, 503])
def test_an_error_of_the_server_itself_is_transient(status: int):
    assert access_error("http://host", response_error(status)) is None
    assert isinstance(as_tracking_error("http://host", response_error(status)), StoreUnavailableError)


def test_a_refused_request_is_neither_transient_nor_about_access():
    assert not is_transient(response_error(413))
    assert access_error("http://host", response_error(413)) is None
