"""Passwords are recognised wherever a URI may have one, and nothing else is taken for one."""

from __future__ import annotations

import pytest

from rl_design_space.errors import ConfigError, has_password, without_passwords


@pytest.mark.parametrize(
    ("uri", "shown"),
    [
        ("http://user:secret@host:5000", "http://user:…@host:5000"),
        ("tracking.uri=postgresql://user:secret@host/db", "tracking.uri=postgresql://user:…@host/db"),
        ("postgresql://user:sec/secret@host/db", "postgresql://user:…@host/db"),
        ("postgresql://user:sec@secret@host/db", "postgresql://user:…@host/db"),
        ("http://:secret@host", "http://:…@host"),
        (
            "postgresql://host/db?user=me&password=secret&sslmode=require",
            "postgresql://host/db?user=me&password=…&sslmode=require",
        ),
    ],
)
def test_a_password_is_left_out(uri: str, shown: str):
    assert has_password(uri)
    assert without_passwords(uri) == shown
    assert "secret" not in str(ConfigError.at("tracking.uri", uri, "no"))


@pytest.mark.parametrize(
    "text",
    [
        "http://host:5000",
        "http://host:5000/experiments/me@home",
        "postgresql://user@host:5432/db",
        "sqlite:////data/a:b@c/mlflow.db",
        "mail me@home: now",
    ],
)
def test_other_uris_are_left_as_they_are(text: str):
    assert not has_password(text)
    assert without_passwords(text) == text
