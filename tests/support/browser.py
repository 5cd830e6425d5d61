"""A headless Chromium over its pipe of the DevTools protocol: no package, no port, no network.

In: a page's path. Out: values of expressions in it, what it said on the console, pictures. Tests that need it are
skipped where no such browser is.
"""

import base64
import json
import os
import shutil
import subprocess
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome")
CHROMIUM = os.environ.get("CHROMIUM") or next(filter(None, map(shutil.which, NAMES)), None)
needs_browser = pytest.mark.skipif(
    CHROMIUM is None, reason=f"no browser: none of {', '.join(NAMES)} is on the path"
)
FLAGS = (
    *("--headless=new", "--no-sandbox", "--disable-extensions", "--hide-scrollbars", "--mute-audio"),
    *("--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--disable-background-networking"),
    *("--no-first-run", "--disable-component-update", "--disable-sync", "--disable-dev-shm-usage"),
)


class Page:
    """One tab, offline from the start."""

    def __init__(self, process: "subprocess.Popen[bytes]", send: int, receive: int) -> None:
        self._process, self._send, self._receive = process, send, receive
        self._buffer = b""
        self._last = 0
        self._session: str | None = None
        self.console: list[str] = []  # messages, exceptions, and requests that left for the network
        target = self._call("Target.createTarget", url="about:blank")["targetId"]
        self._session = self._call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self._call(f"{domain}.enable")
        self._call(
            "Network.emulateNetworkConditions",
            offline=True,
            latency=0,
            downloadThroughput=0,
            uploadThroughput=0,
        )

    def open(
        self, path: Path, *, width: int = 1280, height: int = 900, dark: bool = False, fragment: str = ""
    ) -> None:
        """Opens a file and waits until the page says that it is ready."""
        self.size(width, height)
        scheme = [{"name": "prefers-color-scheme", "value": "dark" if dark else "light"}]
        self._call("Emulation.setEmulatedMedia", features=scheme)
        self._call("Page.navigate", url="about:blank")  # else the same address is no new page
        self._call("Page.navigate", url=path.resolve().as_uri() + fragment)
        self.wait("document.readyState === 'complete' && document.body?.dataset.ready !== undefined")

    def size(self, width: int, height: int) -> None:
        self._call(
            "Emulation.setDeviceMetricsOverride",
            width=width,
            height=height,
            deviceScaleFactor=1,
            mobile=width < 600,
        )

    def value(self, expression: str) -> Any:
        """Of an expression of JavaScript, awaited; an exception there is an AssertionError here."""
        answer = self._call("Runtime.evaluate", expression=expression, awaitPromise=True, returnByValue=True)
        assert "exceptionDetails" not in answer, answer["exceptionDetails"]
        return answer["result"].get("value")

    def wait(self, condition: str, seconds: float = 60.0) -> None:
        """Until an expression is true."""
        end = time.monotonic() + seconds
        while not self.value(f"Boolean({condition})"):
            assert time.monotonic() < end, f"it never came to be: {condition}; {self.console}"
            time.sleep(0.02)

    def picture(self, path: Path) -> Path:
        """A PNG of what is seen."""
        data = self._call("Page.captureScreenshot", format="png")["data"]
        path.write_bytes(base64.b64decode(data))
        return path

    def send(self, method: str, **parameters: Any) -> Any:
        """Any other method, such as Input.dispatchMouseEvent."""
        return self._call(method, **parameters)

    def _call(self, method: str, **parameters: Any) -> Any:
        self._last += 1
        message: dict[str, Any] = {"id": self._last, "method": method, "params": parameters}
        if self._session is not None:
            message["sessionId"] = self._session
        os.write(self._send, json.dumps(message).encode() + b"\0")
        while True:
            answer = self._read()
            if answer.get("id") == self._last:
                assert "error" not in answer, answer["error"]
                return answer["result"]
            self._note(answer)

    def _note(self, event: dict[str, Any]) -> None:
        method, data = event.get("method"), event.get("params", {})
        if method == "Runtime.consoleAPICalled":
            self.console.append(
                " ".join(str(each.get("value", each.get("description"))) for each in data["args"])
            )
        elif method == "Runtime.exceptionThrown":
            self.console.append(str(data["exceptionDetails"].get("exception", data["exceptionDetails"])))
        elif method == "Log.entryAdded":
            self.console.append(data["entry"]["text"])
        elif method == "Network.requestWillBeSent" and not data["request"]["url"].startswith(
            ("file:", "data:", "blob:", "about:")
        ):
            self.console.append(f"asked the network for {data['request']['url']}")

    def _read(self) -> dict[str, Any]:
        while b"\0" not in self._buffer:
            more = os.read(self._receive, 1 << 16)
            assert more, "the browser is gone"
            self._buffer += more
        text, _, self._buffer = self._buffer.partition(b"\0")
        found: dict[str, Any] = json.loads(text)
        return found


@contextmanager
def browser() -> Iterator[Page]:
    """A browser of its own, with a profile that is thrown away."""
    assert CHROMIUM is not None
    to_read, to_send = os.pipe()
    received, to_write = os.pipe()

    def pipes() -> None:  # the browser reads its descriptor 3 and writes to 4
        os.dup2(to_read, 203)
        os.dup2(to_write, 204)
        os.dup2(203, 3)
        os.dup2(204, 4)

    with tempfile.TemporaryDirectory(prefix="lamc-browser-", ignore_cleanup_errors=True) as profile:
        process = subprocess.Popen(
            [CHROMIUM, *FLAGS, "--remote-debugging-pipe", f"--user-data-dir={profile}", "about:blank"],
            stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
            preexec_fn=pipes, close_fds=False,
        )  # fmt: skip
        os.close(to_read)
        os.close(to_write)
        try:
            yield Page(process, to_send, received)
        finally:
            process.kill()
            process.wait()
            os.close(to_send)
            os.close(received)
