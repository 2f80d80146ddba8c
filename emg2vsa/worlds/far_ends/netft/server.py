"""The emulated box on real sockets of the loopback: UDP for records, HTTP for its page."""

from __future__ import annotations

import contextlib
import select
import socket
import threading
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any, Self

from emg2vsa.devices.clock import Clock
from emg2vsa.devices.netft.config import PATH
from emg2vsa.errors import DeviceError
from emg2vsa.worlds.far_ends.netft.box import RdtBox, configuration_page

HOST = "127.0.0.1"
IDLE_S = 0.05
"Longest wait before the server looks whether it shall end."
PACE_S = 5e-4
"Shortest wait: records that fall due within it leave together."


class RdtServer:
    """Serves ``box`` in real time within a with statement, on the ports ``rdt_port`` and ``http_port`` of ``host``.

    Ports that are not given are any that are free. DeviceError when a given one is taken or not allowed.
    """

    def __init__(self, box: RdtBox, clock: Clock, *, rdt_port: int = 0, http_port: int = 0) -> None:
        self.box, self._clock = box, clock
        self.host = HOST
        self._ended = threading.Event()
        self._udp = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            self._udp.bind((HOST, rdt_port))
            self._http = ThreadingHTTPServer((HOST, http_port), _page_of(box))
        except OSError as error:
            self._udp.close()
            raise DeviceError(
                f"{HOST}, ports {rdt_port} (UDP) and {http_port} (HTTP)",
                wanted="two free ports for the emulated box",
                found=error.strerror or str(error),
                do="End the program that holds them, or choose other ports; below 1024 they need a right of their own.",
            ) from error
        self._udp.setblocking(False)
        self.rdt_port: int = self._udp.getsockname()[1]
        self.http_port: int = self._http.server_address[1]
        self._threads = [
            threading.Thread(target=self._send_records, daemon=True),
            threading.Thread(target=self._http.serve_forever, args=(IDLE_S,), daemon=True),
        ]

    def __enter__(self) -> Self:
        for thread in self._threads:
            thread.start()
        return self

    def __exit__(self, *error: object) -> None:
        self._ended.set()
        self._http.shutdown()
        self._http.server_close()
        for thread in self._threads:
            thread.join()
        self._udp.close()

    def _send_records(self) -> None:
        while not self._ended.is_set():
            wait_s = min(max(self.box.next_s - self._clock.now_s(), PACE_S), IDLE_S)
            asked, _, _ = select.select([self._udp], [], [], wait_s)
            if asked:
                data, address = self._udp.recvfrom(2048)
                self.box.request(data, self._client(address), self._clock.now_s())
            self.box.run_until(self._clock.now_s())

    def _client(self, address: Any) -> Any:
        def send(data: bytes, time_s: float) -> None:
            # a client that is gone is no trouble of the box, which sends on
            with contextlib.suppress(OSError):
                self._udp.sendto(data, address)

        return send


def _page_of(box: RdtBox) -> type[BaseHTTPRequestHandler]:
    class Page(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            if self.path.partition("?")[0] != PATH:
                self.send_error(404)
                return
            body = configuration_page(box)
            self.send_response(200)
            self.send_header("Content-Type", "text/xml")
            self.send_header("Content-Length", str(len(body)))
            self.end_headers()
            self.wfile.write(body)

        def log_message(self, format: str, *args: object) -> None:
            """The box keeps no log of who reads its page."""

    return Page
