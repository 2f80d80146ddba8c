"""The emulated box on real sockets of the loopback: UDP for records, HTTP for its pages, TCP for commands."""

from __future__ import annotations

import contextlib
import select
import socket
import socketserver
import threading
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from types import TracebackType
from typing import Any

from emg2vsa.rig.clock import Clock
from emg2vsa.rig.emulated.rdt_box import RdtBox
from emg2vsa.rig.emulated.rdt_pages import TCP_REQUEST_BYTES, calibration_page, configuration_page, tcp_answer

HOST = "127.0.0.1"
IDLE_S = 0.05
"Longest wait before the server looks whether it shall end."
PACE_S = 5e-4
"Shortest wait: records that fall due within it leave together."


class RdtServer:
    """Serves ``box`` in real time from `start` to `close`, or within a with statement.

    rdt_port, http_port, tcp_port : where; chosen by the system unless given.
    """

    def __init__(self, box: RdtBox, clock: Clock, *, rdt_port: int = 0, http_port: int = 0, tcp_port: int = 0) -> None:
        self.box, self._clock = box, clock
        self.host = HOST
        self._box_lock = threading.Lock()
        self._ended = threading.Event()
        self._udp = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._udp.bind((HOST, rdt_port))
        self._udp.setblocking(False)
        self._http = ThreadingHTTPServer((HOST, http_port), _pages_of(box))
        self._tcp = _TcpServer((HOST, tcp_port), _commands_to(self))
        self.rdt_port: int = self._udp.getsockname()[1]
        self.http_port: int = self._http.server_address[1]
        self.tcp_port: int = self._tcp.server_address[1]
        self._threads = [
            threading.Thread(target=self._send_records, daemon=True),
            threading.Thread(target=self._http.serve_forever, args=(IDLE_S,), daemon=True),
            threading.Thread(target=self._tcp.serve_forever, args=(IDLE_S,), daemon=True),
        ]

    def start(self) -> None:
        """Begin to serve."""
        for thread in self._threads:
            thread.start()

    def close(self) -> None:
        """End, and free the ports."""
        self._ended.set()
        for server in (self._http, self._tcp):
            server.shutdown()
            server.server_close()
        for thread in self._threads:
            thread.join()
        self._udp.close()

    def __enter__(self) -> RdtServer:
        self.start()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.close()

    def answer(self, request: bytes) -> bytes:
        """Answer to a command over TCP."""
        with self._box_lock:
            return tcp_answer(self.box, request, self._clock.now_s())

    def _send_records(self) -> None:
        while not self._ended.is_set():
            wait_s = min(max(self.box.next_s - self._clock.now_s(), PACE_S), IDLE_S)
            asked, _, _ = select.select([self._udp], [], [], wait_s)
            with self._box_lock:
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


class _TcpServer(socketserver.ThreadingTCPServer):
    daemon_threads = True


def _pages_of(box: RdtBox) -> type[BaseHTTPRequestHandler]:
    pages = {"/netftapi2.xml": lambda: configuration_page(box), "/netftcalapi.xml": calibration_page}

    class Pages(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            page = pages.get(self.path.partition("?")[0])
            if page is None:
                self.send_error(404)
                return
            body = page()
            self.send_response(200)
            self.send_header("Content-Type", "text/xml")
            self.send_header("Content-Length", str(len(body)))
            self.end_headers()
            self.wfile.write(body)

        def log_message(self, format: str, *args: object) -> None:
            """The box keeps no log of who reads its pages."""

    return Pages


def _commands_to(server: RdtServer) -> type[socketserver.BaseRequestHandler]:
    class Commands(socketserver.StreamRequestHandler):
        def handle(self) -> None:
            while len(request := self.rfile.read(TCP_REQUEST_BYTES)) == TCP_REQUEST_BYTES:
                self.wfile.write(server.answer(request))

    return Commands
