"""A page in a real browser that is waited for, looked at and photographed, through Chromium's debugging pipe."""

from __future__ import annotations

import base64
import json
import os
import shlex
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from tests.browser import CHROMIUM

_FLAGS = (
    *("--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--hide-scrollbars"),
    # A mouse, as most have: without one, every chart shows its tools all the time.
    "--blink-settings=primaryHoverType=2,availableHoverTypes=2,primaryPointerType=4,availablePointerTypes=4",
    *("--disable-background-networking", "--disable-component-update", "--disable-sync", "--disable-dev-shm-usage"),
)
#: Seconds to wait for what a page is to show, and between two looks at it.
_PATIENCE, _PAUSE = 60, 0.1


class Tab:
    """One page of a browser; what goes wrong in the page is an exception here."""

    def __init__(self, commands: int, answers: int) -> None:
        self._commands = commands
        self._answers = answers
        self._buffer = b""
        self._number = 0
        self._session = ""
        target = self._call("Target.createTarget", url="about:blank")["targetId"]
        self._session = self._call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        self._call("Page.enable")

    def size(self, width: int, height: int) -> None:
        """Set the size of the page, in pixels."""
        self._call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=False)

    def before_each_page(self, script: str) -> None:
        """Run JavaScript in every page that is opened from now on, before its own."""
        self._call("Page.addScriptToEvaluateOnNewDocument", source=script)

    def open(self, address: str) -> None:
        """Go to an address, which is a new page even if only the part behind its # differs."""
        self._call("Page.navigate", url="about:blank")
        self._call("Page.navigate", url=address)

    def evaluate(self, expression: str) -> Any:
        """The value of a JavaScript expression, as plain Python."""
        answer = self._call("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in answer:
            raise RuntimeError(f"{expression}: {answer['exceptionDetails']}")
        return answer["result"].get("value")

    def wait(self, condition: str) -> None:
        """Wait until a JavaScript expression is as good as true."""
        deadline = time.monotonic() + _PATIENCE
        while True:
            # While a page is on its way there is no document to ask.
            with suppress(RuntimeError):
                if self.evaluate(f"Boolean({condition})"):
                    return
            if time.monotonic() > deadline:
                raise TimeoutError(f"{condition} did not come true; the page says: {self.text()}")
            time.sleep(_PAUSE)

    def text(self) -> str:
        """What the page says."""
        return str(self.evaluate("document.body.innerText"))

    def click(self, x: float, y: float) -> None:
        """Click with the mouse on a place of the page, in pixels."""
        for kind in ("mouseMoved", "mousePressed", "mouseReleased"):
            self._call("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", clickCount=1)

    def press(self, key: str, code: int) -> None:
        """Press a key, such as Enter, which has the code 13."""
        for kind in ("rawKeyDown", "char", "keyUp"):
            self._call("Input.dispatchKeyEvent", type=kind, key=key, windowsVirtualKeyCode=code, text=chr(code))

    def photograph(self, picture: Path) -> None:
        """Write what can be seen of the page, as PNG."""
        picture.write_bytes(base64.b64decode(self._call("Page.captureScreenshot", format="png")["data"]))

    def _call(self, method: str, **parameters: Any) -> dict[str, Any]:
        self._number += 1
        message: dict[str, Any] = {"id": self._number, "method": method, "params": parameters}
        if self._session:
            message["sessionId"] = self._session
        os.write(self._commands, json.dumps(message).encode() + b"\0")
        while True:
            answer = self._next_message()
            if answer.get("id") == self._number:
                if "error" in answer:
                    raise RuntimeError(f"{method}: {answer['error']}")
                result: dict[str, Any] = answer["result"]
                return result

    def _next_message(self) -> dict[str, Any]:
        while b"\0" not in self._buffer:
            received = os.read(self._answers, 1 << 20)
            if not received:
                raise RuntimeError("the browser has ended")
            self._buffer += received
        message, _, self._buffer = self._buffer.partition(b"\0")
        decoded: dict[str, Any] = json.loads(message)
        return decoded


@contextmanager
def tab(profile: Path) -> Iterator[Tab]:
    """Start a browser with one page, and end it.

    Args:
        profile: folder of the browser's own files.
    """
    for_browser, commands = os.pipe()
    answers, from_browser = os.pipe()
    # The browser reads its descriptor 3 and writes to 4, whatever the numbers are here.
    flags = [*_FLAGS, "--remote-debugging-pipe", f"--user-data-dir={profile}"]
    browser = shlex.join([str(CHROMIUM), *flags, "about:blank"])
    process = subprocess.Popen(
        ["/bin/bash", "-c", f"exec {browser} 3<&{for_browser} 4>&{from_browser}"],
        pass_fds=(for_browser, from_browser),
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    os.close(for_browser)
    os.close(from_browser)
    try:
        yield Tab(commands, answers)
    finally:
        process.terminate()
        process.wait(timeout=30)
        os.close(commands)
        os.close(answers)
