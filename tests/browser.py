"""A real browser without a window: what a page says to it, and whether it complains."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import pytest

from tests.command_runner import PATIENCE

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")

needs_browser = pytest.mark.skipif(CHROMIUM is None, reason="needs Chromium (apt-get install chromium)")

_FLAGS = (
    *("--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--hide-scrollbars"),
    *("--disable-background-networking", "--disable-component-update", "--disable-sync", "--disable-dev-shm-usage"),
    *("--enable-logging=stderr", "--v=0", "--virtual-time-budget=5000"),
)


def opened(page: Path, profile: Path, *flags: str) -> tuple[str, list[str]]:
    """The page's document as the browser has it, and the complaints on its console."""
    command = [str(CHROMIUM), *_FLAGS, f"--user-data-dir={profile}", *flags, "--dump-dom", page.as_uri()]
    done = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE)
    assert done.returncode == 0, done.stderr
    return done.stdout, re.findall(r"CONSOLE.*", done.stderr)


def photographed(page: Path, profile: Path, picture: Path, width: int, height: int) -> None:
    """Write a screenshot of the top of a page."""
    flags = [*_FLAGS, f"--user-data-dir={profile}", f"--window-size={width},{height}", f"--screenshot={picture}"]
    done = subprocess.run([str(CHROMIUM), *flags, page.as_uri()], capture_output=True, text=True, timeout=PATIENCE)
    assert done.returncode == 0, done.stderr
