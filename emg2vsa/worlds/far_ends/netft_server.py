"""Ways to the emulated box: real sockets of the loopback, UDP for records and HTTP for its page; or none at all."""

from __future__ import annotations

import contextlib
import select
import socket
from http.server import BaseHTTPRequestHandler
from typing import Any

from emg2vsa.devices.clock import Clock
from emg2vsa.devices.netft.box import PATH, Record
from emg2vsa.devices.netft.driver import NetFt
from emg2vsa.errors import DeviceError
from emg2vsa.worlds.far_ends.netft_box import RdtBox, configuration_page
from emg2vsa.worlds.far_ends.ports import HOST, IDLE_S, Page, Serving

PACE_S = 5e-4
"Shortest wait: records that fall due within it leave together."
_RESTLESS_COUNTS = 100
"Noise of this standard deviation never leaves all six counts of a record as those of the one before."


class RdtServer(Serving):
    """Serves ``box`` in real time within a with statement, on the ports ``rdt_port`` and ``http_port`` of ``host``.

    Ports that are not given are any that are free. DeviceError when a given one is taken or not allowed.
    """

    def __init__(self, box: RdtBox, clock: Clock, *, rdt_port: int = 0, http_port: int = 0) -> None:
        self.box, self._clock = box, clock
        self.host = HOST
        self._udp = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            self._udp.bind((HOST, rdt_port))
            page = Page(http_port, PATH, self._write_page)
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
        self.http_port = page.port
        super().__init__(self._send_records, lambda: page.serve(self._ended), name="Net F/T box")

    def _close(self) -> None:
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

    def _write_page(self, client: BaseHTTPRequestHandler) -> None:
        body = configuration_page(self.box)
        client.send_response(200)
        client.send_header("Content-Type", "text/xml")
        client.send_header("Content-Length", str(len(body)))
        client.end_headers()
        client.wfile.write(body)


class DirectNetFt(NetFt):
    """A driver that, once a stream has begun, takes its records straight from the ``box`` in this process, without
    datagrams. What it says is what `NetFt` says (tests/worlds/bench/test_virtual_run.py).

    all_records : somebody wants more than the newest of each turn.
    """

    def __init__(self, *given: Any, box: RdtBox, all_records: bool, **named: Any) -> None:
        self._box = box
        counts = box.settings.counts_per_force, box.settings.counts_per_torque
        noise = min(size * per_unit for size, per_unit in zip(box.settings.noise, counts, strict=True))
        self._newest_only = noise >= _RESTLESS_COUNTS and not all_records
        super().__init__(*given, **named)

    def _arrived(self) -> bool:
        if self._newest is None:
            return super()._arrived()
        now_s = self._clock.now_s()
        if now_s == self._looked_s:
            return True
        self._looked_s = now_s
        # as a stream without gaps: faults are put only into exact benches
        if self._newest_only:
            if (found := self._box.newest_until(now_s)) is not None:
                self._accept(*found, now_s)
        else:
            for record, sent_s in self._box.records_until(now_s):
                self._unread.append(self._accept(record, sent_s, now_s))
        return True

    def _accept(self, record: Record, sent_s: float, now_s: float) -> tuple[Record, float]:
        assert self._newest is not None
        newest, newest_s = self._newest
        age_s = now_s - sent_s
        newest_s = max(now_s - age_s, newest_s)  # as of a datagram, whose age is told
        if record.counts != newest.counts:
            self._changed_s = newest_s
        self._records += record.rdt_sequence - newest.rdt_sequence
        self._newest = record, newest_s
        return self._newest
