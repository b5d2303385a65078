"""Passwords and tokens are recognised wherever an address may have one, and nothing else is taken for one."""

from __future__ import annotations

import string
import time
from urllib.parse import quote

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from rl_design_space._secrets import has_secret, without_secrets
from rl_design_space.errors import ConfigError
from rl_design_space.tracking.store_errors import StoreUnavailableError


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("http://user:secret@host:5000", "http://…@host:5000"),
        ("tracking.uri=postgresql://user:secret@host/db", "tracking.uri=postgresql://user:…@host/db"),
        ("postgresql://user:sec/secret@host/db", "postgresql://user:…@host/db"),
        ("postgresql://user:123/secret@host/db", "postgresql://user:…@host/db"),
        ("postgresql://user:sec@secret@host/db", "postgresql://user:…@host/db"),
        ("http://:secret@host", "http://…@host"),
        ("http://secret@host", "http://…@host"),
        ("http://secret:x-oauth-basic@host", "http://…@host"),
        ("HTTPS://secret@host:443/path", "HTTPS://…@host:443/path"),
        ("http:/secret@host", "http:/…@host"),
        ("http:secret@host", "http:…@host"),
        ("http://%73ecret@host", "http://…@host"),
        ("postgresql://user%3Asecret@host", "postgresql://…@host"),
        ("postgresql://user%253Asecret@host", "postgresql://…@host"),
        ("http://secret%40host@host", "http://…@host"),
        (r"http\://user\:secret@host", "http://…@host"),
        ("tracking.uri=sqlite:///a.db,http://secret@host", "tracking.uri=sqlite:///a.db,http://…@host"),
        (
            "postgresql://host/db?user=me&password=secret&sslmode=require",
            "postgresql://host/db?user=me&password=…&sslmode=require",
        ),
        ("postgresql://me@host/db?sslpassword=secret", "postgresql://me@host/db?sslpassword=…"),
        ("postgresql://me@host/db?SSLPassword=secret", "postgresql://me@host/db?SSLPassword=…"),
        ("postgresql://me@host/db?%70assword=secret&a=b", "postgresql://me@host/db?…&a=b"),
        ("postgresql://me@host/db?password%3Dsecret", "postgresql://me@host/db?…"),
        ("mssql+pyodbc:///?odbc_connect=UID%3Dme%3BPWD%3Dsecret", "mssql+pyodbc:///?…"),
        ("http://host/#access_token=secret", "http://host/#access_token=…"),
        ("http://host?api_key=secret;x=1", "http://host?api_key=…;x=1"),
        ("+hydra.job.env_set.PGPASSWORD=secret", "+hydra.job.env_set.PGPASSWORD=…"),
        ("hydra.launcher.token=secret", "hydra.launcher.token=…"),
    ],
)
def test_a_secret_is_left_out(text: str, shown: str):
    assert has_secret(text)
    assert without_secrets(text) == shown
    for error in (ConfigError.at("tracking.uri", text, "no"), ConfigError(text), StoreUnavailableError(text)):
        assert "ecret" not in str(error)
    assert str(ConfigError(f"{shown}: no")) == f"{shown}: no"


@pytest.mark.parametrize(
    "text",
    [
        "http://host:5000",
        "http://host:5000/experiments/me@home",
        "http://[::1]:5000/me@home",
        "postgresql://user@host:5432/db",
        "postgresql://user@host/db?passfile=/home/me/.pgpass&sslkey=/key&options=-c%20x%3Dy",
        "sqlite:////data/a:b@c/mlflow.db",
        "file:///home/me@host:x/y",
        "databricks://profile:prefix",
        "tls://10.0.0.1:8786",
        "mail me@home: now",
        "+hydra.job.env_set.PGPASSWORD=${oc.env:PGPASSWORD}",
        "representation.tokens=3",
        "params.token = 'x'",
        r"a\,b",
    ],
)
def test_other_texts_are_left_as_they_are(text: str):
    assert not has_secret(text)
    assert without_secrets(text) == text
    assert str(ConfigError(text)) == text


def test_an_address_with_spaces_is_read_whole():
    assert has_secret("tracking.uri='http://user:my secret@host'")
    assert "secret" not in str(ConfigError.at("tracking.uri", "http://user:my secret@host", "no"))
    assert str(ConfigError("http://host: mail me@home")) == "http://host: mail me@home"


#: Characters of secrets: those that a URI may hold as they are, and those that have a meaning in it.
SECRETS = st.text(string.ascii_letters + string.digits + "-._~!$'()*+,:@/\\%", min_size=8, max_size=20)
HOSTS = st.sampled_from(["host", "host:5000", "10.0.0.1", "[::1]:80"])
ENDS = st.sampled_from(["", "/", "/db", "/db?a=b", "?a=b", "#x"])


@settings(max_examples=50)
@given(SECRETS, HOSTS, ENDS, st.sampled_from(["", "tracking.uri=", "error: "]), st.booleans())
def test_no_password_of_a_database_is_shown(secret: str, host: str, end: str, before: str, encoded: bool):
    typed = quote(secret, safe="") if encoded else secret
    text = f"{before}postgresql://me:{typed}@{host}{end}"
    assert has_secret(text)
    assert typed not in without_secrets(text)
    assert without_secrets(without_secrets(text)) == without_secrets(text)


@settings(max_examples=50)
@given(SECRETS, HOSTS, ENDS, st.sampled_from(["http", "https", "HTTP"]), st.booleans())
def test_no_token_of_a_server_is_shown(secret: str, host: str, end: str, scheme: str, encoded: bool):
    typed = quote(secret, safe="") if encoded else secret.replace("/", "")
    assume(typed.strip(":@"))
    text = f"{scheme}://{typed}@{host}{end}"
    assert has_secret(text)
    assert typed not in without_secrets(text)


@given(
    SECRETS,
    st.sampled_from(["password", "sslpassword", "PASSWORD", "token", "access_token", "client_secret", "apikey"]),
    st.integers(0, 12),
    st.sampled_from("?&;#"),
)
def test_no_secret_among_the_parameters_is_shown(secret: str, name: str, encoded: int, separator: str):
    name = "".join(f"%{ord(letter):02X}" if place == encoded else letter for place, letter in enumerate(name))
    text = f"postgresql://me@host/db?a=b{separator}{name}={quote(secret, safe='')}"
    assert has_secret(text)
    assert quote(secret, safe="") not in without_secrets(text)


@pytest.mark.parametrize("text", ["x", "a:/", "&", "?token", "http:", "%26", "http://a@", "\\&"])
def test_a_long_message_is_cut_and_read_at_once(text: str):
    begun = time.process_time()
    assert len(str(ConfigError(text * 10**6))) < 20_000
    assert time.process_time() - begun < 5  # hours if each beginning was searched to the end


@settings(max_examples=50)
@given(st.text())
def test_any_text_is_read(text: str):
    assert has_secret(text) in (True, False)
    assert without_secrets(without_secrets(text)) == without_secrets(text)
