"""The service of docs/server/compose.yaml runs, with the versions of the lock file."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import pytest
import yaml

from tests.command_runner import SCRIPTS, environment, output_of
from tests.servers import PROGRAMS, HttpService, Postgres, needs_postgres
from tests.service import free_port
from tests.tracking.stores import import_mlflow

ROOT = Path(__file__).parent.parent
FOLDER = ROOT / "docs" / "server"
COMPOSE = (FOLDER / "compose.yaml").read_text(encoding="utf-8")
_VARIABLE = re.compile(r"\$\{(\w+)(?::([-?])([^}]*))?\}")


def composed(**values: str) -> dict:
    """Return the services as Compose reads them, with these variables of an .env file."""

    def value(found: re.Match[str]) -> str:
        name, kind, text = found.groups()
        if name in values:
            return values[name]
        assert kind == "-", f"{name}: needs a value"
        return text

    return yaml.safe_load(_VARIABLE.sub(value, COMPOSE))


#: Variables that the example leaves empty.
SECRETS = {"POSTGRES_PASSWORD": "of-postgres", "ADMIN_PASSWORD": "of-the-admin", "SECRET_KEY": "of-cookies"}


def test_the_example_lists_every_variable_and_contains_no_password():
    lines = re.findall(r"^#?([A-Z_]+)=(.*)$", (FOLDER / ".env.example").read_text(encoding="utf-8"), re.MULTILINE)
    assert {name for name, *_ in _VARIABLE.findall(COMPOSE)} == {name for name, _ in lines}
    assert {name for name, text in lines if not text} == set(SECRETS)


def test_packages_have_the_versions_of_the_lock_file():
    locked = dict(re.findall(r"^([\w-]+)==([^\s;]+)", (ROOT / "requirements-test.txt").read_text(), re.MULTILINE))
    recipe = composed(**SECRETS)["services"]["mlflow"]["build"]["dockerfile_inline"]
    (packages,) = re.findall(r"pip install --no-cache-dir (.*)", recipe)
    for package in packages.split():
        name, version = re.fullmatch(r'"?([\w-]+)(?:\[\w+\])?==([\d.]+)"?', package).groups()
        assert locked[name] == version
    assert {"mlflow", "psycopg", "sqlalchemy", "flask-wtf", "uvloop"} == set(
        re.findall(r"([\w-]+)(?:\[\w+\])?==", packages)
    )


def test_images_are_pinned():
    services = composed(**SECRETS)["services"]
    recipe = services["mlflow"]["build"]["dockerfile_inline"]
    assert re.match(r"FROM python:\d+\.\d+\.\d+-", recipe)
    assert re.match(r"postgres:\d+\.\d+-", services["postgres"]["image"])


def test_the_image_searches_for_garbage_less_often(tmp_path: Path):
    recipe = composed(**SECRETS)["services"]["mlflow"]["build"]["dockerfile_inline"]
    (line, path), *others = re.findall(r'RUN echo "(.*)" > (.*)', recipe)
    assert not others
    # The folder belongs to the Python of the image.
    version = re.search(r"FROM python:(\d+\.\d+)\.", recipe)[1]
    assert path == f"/usr/local/lib/python{version}/site-packages/sitecustomize.py"
    (tmp_path / "sitecustomize.py").write_text(line, encoding="utf-8")
    asked = [SCRIPTS / "python", "-c", "import gc; print(gc.get_threshold()[0])"]
    assert output_of(*asked, env={"PYTHONPATH": str(tmp_path)}) == "50000\n"


@needs_postgres
def test_postgresql_is_the_one_that_is_tested():
    tested = re.search(r"\d+", output_of(PROGRAMS / "postgres", "--version"))[0]
    image = composed(**SECRETS)["services"]["postgres"]["image"]
    if not image.startswith(f"postgres:{tested}."):
        pytest.skip(f"this machine has PostgreSQL {tested}, not that of {image}")


def test_only_this_machine_has_access_by_default():
    services = composed(**SECRETS)["services"]
    assert "ports" not in services["postgres"]
    assert services["mlflow"]["ports"] == ["127.0.0.1:5000:5000"]
    assert all("healthcheck" in service for service in services.values())
    assert composed(**SECRETS, BIND="10.0.0.1")["services"]["mlflow"]["ports"] == ["10.0.0.1:5000:5000"]


@needs_postgres
def test_the_mlflow_service_runs_as_described(postgres: Postgres, tmp_path: Path, monkeypatch):
    uri = postgres.create(password=SECRETS["POSTGRES_PASSWORD"])
    port, database = free_port(), uri.rpartition("/")[2]
    here = {
        "postgresql://mlflow@postgres:5432/mlflow": f"postgresql://{database}@127.0.0.1:{postgres.port}/{database}",
        "/artifacts": str(tmp_path / "artifacts"),
        "/basic_auth.ini": str(tmp_path / "basic_auth.ini"),
        "0.0.0.0": "127.0.0.1",
        "5000": str(port),
        "mlflow": str(SCRIPTS / "mlflow"),
    }
    described = composed(**SECRETS, ADMIN_USERNAME="chief")
    service = described["services"]["mlflow"]
    config = described["configs"]["basic_auth"]["content"]
    for original, replaced in list(here.items())[:1]:
        assert original in config
        config = config.replace(original, replaced)
    (tmp_path / "basic_auth.ini").write_text(config, encoding="utf-8")
    variables = {name: here.get(text, text) for name, text in service["environment"].items()}
    server = HttpService(
        command=[here.get(word, word) for word in service["command"]],
        environment={**environment(tmp_path, **variables), "TMPDIR": str(tmp_path)},
        port=port,
        folder=tmp_path,
    )
    import_mlflow()
    from mlflow import MlflowClient
    from mlflow.exceptions import MlflowException

    monkeypatch.setenv("MLFLOW_HTTP_REQUEST_MAX_RETRIES", "0")
    monkeypatch.setenv("MLFLOW_SUPPRESS_PRINTING_URL_TO_STDOUT", "true")
    with server:
        client = MlflowClient(server.uri)
        with pytest.raises(MlflowException, match="401"):
            client.search_experiments()
        for name, text in (("USERNAME", "chief"), ("PASSWORD", SECRETS["ADMIN_PASSWORD"])):
            monkeypatch.setenv(f"MLFLOW_TRACKING_{name}", text)
        run = client.create_run(client.create_experiment("composed")).info.run_id
        client.log_text(run, "task: {}\n", "config.yaml")
        assert list((tmp_path / "artifacts").rglob(f"{run}/artifacts/config.yaml"))
        # The healthcheck, at the port of this test.
        _, _, option, script = service["healthcheck"]["test"]
        probe = [SCRIPTS / "python", option, script.replace("5000", str(port))]
        subprocess.run(probe, check=True, timeout=30)
    assert subprocess.run(probe, check=False, capture_output=True, timeout=30).returncode
