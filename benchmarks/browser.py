"""A real browser without a window, driven through its DevTools."""

from __future__ import annotations

import base64
import json
import shutil
import subprocess
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from websockets.sync.client import ClientConnection, connect

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
_ARGUMENTS = (
    "--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--remote-debugging-port=0", "--no-first-run",
    "--disable-gpu", "--hide-scrollbars", "--autoplay-policy=no-user-gesture-required", "about:blank",
)  # fmt: skip


class Browser:
    """Windows of one browser, for any thread."""

    def __init__(self, connection: ClientConnection) -> None:
        self._connection, self._count = connection, 0
        self._lock = threading.Lock()

    def open(self, address: str, width: int = 1280, height: int = 800) -> Window:
        """A window of its own: a page in a hidden tab is not drawn."""
        opened = self.call("Target.createTarget", url="about:blank", newWindow=True, width=width, height=height)
        attached = self.call("Target.attachToTarget", targetId=opened["targetId"], flatten=True)
        window = Window(self, attached["sessionId"], opened["targetId"])
        window.size(width, height)
        window.go(address)
        return window

    def call(self, method: str, session: str | None = None, **parameters: Any) -> dict[str, Any]:
        with self._lock:
            self._count += 1
            message = {"id": self._count, "method": method, "params": parameters}
            self._connection.send(json.dumps(message | ({"sessionId": session} if session else {})))
            while True:
                answer = json.loads(self._connection.recv(timeout=60))
                if answer.get("id") == self._count:
                    assert "error" not in answer, answer
                    result: dict[str, Any] = answer["result"]
                    return result


class Window:
    """One page."""

    def __init__(self, browser: Browser, session: str, target: str) -> None:
        self._browser, self._session, self._target = browser, session, target

    def call(self, method: str, **parameters: Any) -> dict[str, Any]:
        return self._browser.call(method, self._session, **parameters)

    def go(self, address: str) -> None:
        self.call("Page.navigate", url=address)
        self.until("document.readyState === 'complete'")

    def size(self, width: int, height: int, scheme: str = "light") -> None:
        self.call(
            "Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=width < 600
        )
        feature = {"name": "prefers-color-scheme", "value": scheme}
        self.call("Emulation.setEmulatedMedia", features=[feature])

    def value(self, expression: str) -> Any:
        """Of JavaScript; promises are awaited."""
        answer = self.call("Runtime.evaluate", expression=expression, awaitPromise=True, returnByValue=True)
        assert "exceptionDetails" not in answer, answer
        return answer["result"].get("value")

    def until(self, condition: str, within_s: float = 15.0) -> Any:
        """The first true value of an expression."""
        end_s = time.monotonic() + within_s
        while not (value := self.value(condition)):
            assert time.monotonic() < end_s, f"not within {within_s} s: {condition}\n{self.text()}"
            time.sleep(0.02)
        return value

    def text(self) -> str:
        return str(self.value("document.body.innerText"))

    def key(self, key: str, repeat: bool = False) -> None:
        text = {"text": "\r" if key == "Enter" else key} if len(key) == 1 or key == "Enter" else {}
        codes = {"PageDown": 34, "PageUp": 33, "Escape": 27, " ": 32, "F5": 116, "Enter": 13}
        code = {"windowsVirtualKeyCode": codes.get(key, ord(key[0].upper()))}
        self.call("Input.dispatchKeyEvent", type="keyDown", key=key, autoRepeat=repeat, **text, **code)
        if not repeat:
            self.call("Input.dispatchKeyEvent", type="keyUp", key=key, **code)

    def click(self, selector: str) -> None:
        self.value(f"document.querySelector({json.dumps(selector)}).click()")

    def picture(self, path: Path, scale: float = 1.0) -> None:
        width, height = self.value("[innerWidth, innerHeight]")
        clip = {"x": 0, "y": 0, "width": width, "height": height, "scale": scale}
        image = self.call("Page.captureScreenshot", format="png", clip=clip)["data"]
        path.write_bytes(base64.b64decode(image))

    def close(self) -> None:
        self._browser.call("Target.closeTarget", targetId=self._target)


@contextmanager
def running(folder: Path) -> Iterator[Browser]:
    """A browser whose files are in ``folder``."""
    assert CHROMIUM is not None
    command = [CHROMIUM, *_ARGUMENTS[:-1], f"--user-data-dir={folder}", _ARGUMENTS[-1]]
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as process:
        try:
            port_file, end_s = folder / "DevToolsActivePort", time.monotonic() + 30
            while not (port_file.exists() and port_file.read_text().count("\n")):
                assert time.monotonic() < end_s, "Chromium does not start"
                time.sleep(0.05)
            port, path = port_file.read_text().split()
            url = f"ws://127.0.0.1:{port}{path}"
            with connect(url, origin=None, proxy=None, max_size=None) as connection:
                yield Browser(connection)
        finally:
            process.kill()
