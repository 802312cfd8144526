"""A real browser as tests use it: Chromium without a window, spoken to through its own protocol."""

import base64
import json
import os
import shutil
import subprocess
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

_NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome")
_FLAGS = (
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--disable-dev-shm-usage",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--hide-scrollbars",
)


_CONTRAST = """
(names => names.map(name => {
  const channels = colour => colour.match(/[\\d.]+/g).map(Number);
  const luminance = colour => {
    const parts = channels(colour).slice(0, 3).map(v => v / 255)
      .map(v => v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4);
    return 0.2126 * parts[0] + 0.7152 * parts[1] + 0.0722 * parts[2];
  };
  const element = document.querySelector(name);
  const isClear = one => channels(getComputedStyle(one).backgroundColor)[3] === 0;
  let behind = element;
  while (behind.parentElement && isClear(behind)) behind = behind.parentElement;
  const ink = luminance(getComputedStyle(element).color);
  const paper = luminance(getComputedStyle(behind).backgroundColor);
  return (Math.max(ink, paper) + 0.05) / (Math.min(ink, paper) + 0.05);
}))
"""


def chromium() -> str:
    """Path of the browser; AssertionError that says what to install if there is none."""
    found = next(filter(None, map(shutil.which, _NAMES)), None)
    assert found, (
        "tests of HTML reports need a browser: install Chromium (on Debian: apt-get install chromium)"
    )
    return found


class Page:
    """A page that is open in the browser.

    The protocol is spoken through two pipes, one message ended by a zero byte each; what the browser tells unasked
    is kept in `events`.
    """

    def __init__(self, commands: int, answers: int) -> None:
        self._commands = os.fdopen(commands, "wb", buffering=0)
        self._answers = os.fdopen(answers, "rb", buffering=0)
        self._number, self._buffer = 0, b""
        self._context, self._session = "", ""
        self.events: list[dict[str, Any]] = []

    def renew(self, width: int, height: int) -> None:
        """Open an empty page of this size that reports its errors and requests; it shares nothing with the last one."""
        self._session = ""
        if self._context:
            self.send("Target.disposeBrowserContext", browserContextId=self._context)
        self._context = self.send("Target.createBrowserContext")["browserContextId"]
        target = self.send("Target.createTarget", url="about:blank", browserContextId=self._context)[
            "targetId"
        ]
        self._session = self.send("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        self.events.clear()
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.send(f"{domain}.enable")
        self.resize(width, height)

    def resize(self, width: int, height: int) -> None:
        """Give the page another size."""
        metrics = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False}
        self.send("Emulation.setDeviceMetricsOverride", **metrics)

    def send(self, method: str, **parameters: Any) -> dict[str, Any]:
        """Answer to a command."""
        self._number += 1
        message = {"id": self._number, "method": method, "params": parameters}
        if self._session:
            message["sessionId"] = self._session
        self._commands.write(json.dumps(message).encode() + b"\0")
        while True:
            answer = self._receive()
            if answer.get("id") == self._number:
                assert "error" not in answer, f"{method}: {answer['error']}"
                return dict(answer["result"])
            self._keep(answer)

    def _receive(self) -> dict[str, Any]:
        while b"\0" not in self._buffer:
            part = os.read(self._answers.fileno(), 1 << 20)
            assert part, "the browser has ended"
            self._buffer += part
        message, _, self._buffer = self._buffer.partition(b"\0")
        return dict(json.loads(message))

    def _keep(self, event: dict[str, Any]) -> None:
        if event.get("sessionId", "") == self._session:  # not of a page that is closed
            self.events.append(event)

    def open(self, file: Path) -> None:
        """Open a file and wait until it is loaded."""
        self.send("Page.navigate", url=file.resolve().as_uri())
        while not any(event["method"] == "Page.loadEventFired" for event in self.events):
            self._keep(self._receive())

    def close(self) -> None:
        """End the browser, and with it the pipes."""
        self._session = ""
        with suppress(OSError, AssertionError):
            self.send("Browser.close")
        self._commands.close()
        self._answers.close()

    def evaluate(self, script: str) -> Any:
        """Value of an expression of JavaScript; promises are awaited."""
        answer = self.send("Runtime.evaluate", expression=script, awaitPromise=True, returnByValue=True)
        assert "exceptionDetails" not in answer, answer["exceptionDetails"]
        return answer["result"].get("value")

    def prefer(self, scheme: str, media: str = "screen") -> None:
        """Show pages as to a reader who prefers "light" or "dark", on a screen or in print."""
        wanted = [{"name": "prefers-color-scheme", "value": scheme}]
        self.send("Emulation.setEmulatedMedia", media=media, features=wanted)

    def contrasts(self, *selectors: str) -> dict[str, float]:
        """Contrast of the text of elements with what is behind it, by WCAG 2: 4.5 is level AA."""
        found = self.evaluate(f"{_CONTRAST}({json.dumps(selectors)})")
        return dict(zip(selectors, found, strict=True))

    def drag(self, begin: tuple[float, float], end: tuple[float, float]) -> None:
        """Press the mouse at one place, move it to another and let it go."""
        middle = ((begin[0] + end[0]) / 2, (begin[1] + end[1]) / 2)
        steps = [("mouseMoved", begin, 0), ("mousePressed", begin, 1), ("mouseMoved", middle, 1)]
        for kind, (x, y), buttons in [*steps, ("mouseMoved", end, 1), ("mouseReleased", end, 0)]:
            self.send(
                "Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", buttons=buttons, clickCount=1
            )

    def picture(self, box: Mapping[str, float]) -> bytes:
        """A rectangle of the page, with `x`, `y`, `width` and `height`, as PNG."""
        clip = {name: box[name] for name in ("x", "y", "width", "height")} | {"scale": 1}
        shot = self.send("Page.captureScreenshot", captureBeyondViewport=True, clip=clip)
        return base64.b64decode(shot["data"])

    @property
    def complaints(self) -> list[str]:
        """Errors and warnings of scripts and of the browser about the page."""
        messages = []
        for event in self.events:
            parameters = event.get("params", {})
            if event["method"] == "Runtime.exceptionThrown":
                messages.append(str(parameters["exceptionDetails"]))
            elif event["method"] == "Log.entryAdded" and parameters["entry"]["level"] in ("warning", "error"):
                messages.append(parameters["entry"]["text"])
            elif event["method"] == "Runtime.consoleAPICalled" and parameters["type"] in ("warning", "error"):
                messages.append(str([argument.get("value") for argument in parameters["args"]]))
        return messages

    @property
    def requests(self) -> list[str]:
        """Addresses that the page asked for."""
        asked = (event for event in self.events if event["method"] == "Network.requestWillBeSent")
        return [event["params"]["request"]["url"] for event in asked]


@contextmanager
def running_browser(profile: Path) -> Iterator[Page]:
    """A browser that keeps its data in a folder of its own, before its first page."""
    to_browser, commands = os.pipe()
    answers, from_browser = os.pipe()
    command = [chromium(), *_FLAGS, "--remote-debugging-pipe", f"--user-data-dir={profile}"]
    redirected = f'exec "$@" 3<&{to_browser} 4>&{from_browser}'
    process = subprocess.Popen(
        ["bash", "-c", redirected, "browser", *command],
        pass_fds=(to_browser, from_browser),
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    os.close(to_browser)
    os.close(from_browser)
    page = Page(commands, answers)
    try:
        yield page
    finally:
        page.close()
        try:
            process.wait(timeout=20)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
