"""Processes that are measured, with a limit on the time that they may take."""

from __future__ import annotations

import subprocess
from collections.abc import Mapping, Sequence

from benchmarks.client import LIMIT, ROOT


def run(command: Sequence[str], env: Mapping[str, str] | None = None) -> subprocess.CompletedProcess[str]:
    """Run a command in the root of the repository and return what it wrote.

    Raises:
        RuntimeError: it failed; with the end of what it wrote.
    """
    done = subprocess.run(command, cwd=ROOT, env=env, capture_output=True, text=True, timeout=LIMIT)
    if done.returncode:
        raise RuntimeError(f"{command} ended with status {done.returncode}: {(done.stderr or done.stdout)[-2000:]}")
    return done
