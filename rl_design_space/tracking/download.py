"""Files of runs that are not on this machine."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING
from urllib.parse import urlsplit

from rl_design_space.tracking.tracker import StoredRun

if TYPE_CHECKING:
    from mlflow import MlflowClient

#: Scheme of the files that a tracking server hands out itself.
_OF_SERVER = "mlflow-artifacts"


def download(client: MlflowClient, run: StoredRun, name: str, folder: Path) -> Path:
    """Download a file of a run into a folder; return its path.

    MLflow's client sends five requests for a file. Of files that the tracking server hands out itself, the one with the
    content is enough; any other answer is left to the client, which finds out what is wrong. See
    docs/decisions/0043-reading-from-a-server.md.

    Args:
        client: of the store.
        run: of the file.
        name: of the file.
        folder: an empty one.

    Raises:
        Exception: whatever MLflow raises.
    """
    content = _handed_out(client.tracking_uri, run.artifacts, name)
    if content is None:
        return Path(client.download_artifacts(run.run_id, name, str(folder)))
    path = folder / name
    path.write_bytes(content)
    return path


def _handed_out(server: str, artifacts: str, name: str) -> bytes | None:
    """Return the content of a file; None if the server does not hand it out.

    Args:
        server: URI of the tracking store.
        artifacts: URI of the folder of the run.
        name: of the file.
    """
    place = urlsplit(artifacts)
    if place.scheme != _OF_SERVER or place.netloc or not server.startswith("http"):
        return None
    from mlflow.store.artifact.mlflow_artifacts_repo import MlflowArtifactsRepository
    from mlflow.utils.credentials import get_default_host_creds
    from mlflow.utils.rest_utils import http_request

    folder = MlflowArtifactsRepository.resolve_uri(artifacts, server)  # type: ignore[no-untyped-call]
    credentials = get_default_host_creds(folder)  # type: ignore[no-untyped-call]
    answer = http_request(credentials, f"/{name}", "GET")  # type: ignore[no-untyped-call]
    return bytes(answer.content) if answer.status_code == 200 else None
