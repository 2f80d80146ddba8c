"""The emulated camera as a network camera: motion JPEG over HTTP, which OpenCV opens like any other."""

from __future__ import annotations

import contextlib
import threading
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Self

import cv2

from emg2vsa.worlds.far_ends.camera.frames import EmulatedCamera

HOST = "127.0.0.1"
PATH = "/frames.mjpg"
JPEG_QUALITY = 100
_POLL_S = 2e-3


class CameraServer:
    """Shows ``camera`` to one client after the other, in real time, within a with statement. url : what to open."""

    def __init__(self, camera: EmulatedCamera) -> None:
        self.camera = camera
        self._ended = threading.Event()
        self._http = ThreadingHTTPServer((HOST, 0), _stream_of(self))
        self.url = f"http://{HOST}:{self._http.server_address[1]}{PATH}"
        self._thread = threading.Thread(target=self._http.serve_forever, args=(0.05,), daemon=True)

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, *error: object) -> None:
        self._ended.set()
        self._http.shutdown()
        self._thread.join()
        self._http.server_close()

    def next_pictures(self) -> list[bytes] | None:
        """JPEG files of the frames taken since the last call; waits for the first; None at the end."""
        while not self._ended.is_set():
            if frames := self.camera.exposed():
                quality = [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY]
                return [cv2.imencode(".jpg", frame.image, quality)[1].tobytes() for frame in frames]
            self._ended.wait(_POLL_S)
        return None


def _stream_of(server: CameraServer) -> type[BaseHTTPRequestHandler]:
    class Stream(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            if self.path != PATH:
                self.send_error(404)
                return
            self.send_response(200)
            self.send_header("Content-Type", "multipart/x-mixed-replace; boundary=frame")
            self.end_headers()
            server.camera.start()
            # a client that goes away ends its stream
            with contextlib.suppress(OSError):
                while (pictures := server.next_pictures()) is not None:
                    for picture in pictures:
                        head = f"--frame\r\nContent-Type: image/jpeg\r\nContent-Length: {len(picture)}\r\n\r\n"
                        self.wfile.write(head.encode() + picture + b"\r\n")

        def log_message(self, format: str, *args: object) -> None:
            """A camera keeps no log of who watches."""

    return Stream
