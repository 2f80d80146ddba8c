"""Question and answer over a line that may lose bytes: timeouts, retries, resynchronisation, a count of losses; and who
is on the line."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from serial.tools import list_ports

from emg2vsa.devices.board import ids_asked
from emg2vsa.devices.clock import Clock
from emg2vsa.devices.qbmove.packets import Command, Reply, Wanted, find_reply, flushing, frame, ping_reply
from emg2vsa.devices.serial_line import ByteLine, LineCounts

_QUIET_S = 0.05
_TEXT_BYTES, _LONGEST_TEXT, _TEXT_S = 4096, 16384, 0.5
"""Read at once; the longest text, of which 2000 are used, and the time it may take: more is noise without an end."""
_FTDI_VENDOR, _MANUFACTURER = 0x0403, "QB Robotics"
_SCAN_ATTEMPTS = 2


class Conversation:
    """Frames to a device and back."""

    def __init__(self, line: ByteLine, clock: Clock) -> None:
        self.line, self.clock, self.counts = line, clock, LineCounts()

    def tell(self, request: bytes) -> None:
        """Send what is not answered."""
        self.line.write(request)
        self.counts.requests += 1

    def ask(self, request: bytes, expected: Wanted, *, timeout_s: float, attempts: int) -> Reply | None:
        """The reply, or None after so many attempts that each waited ``timeout_s``, s."""
        for attempt in range(attempts):
            if attempt:
                self.line.write(flushing(request))
            self.line.drop_input()
            self.tell(request)
            reply = self._hear(expected, timeout_s)
            if reply:
                return reply
            self.counts.lost += 1
        return None

    def ask_text(self, request: bytes, *, timeout_s: float, again: bool) -> str:
        """The bare text that follows ``request``, until the line falls silent, or longer than any text.

        timeout_s : until its first byte, s. again : the last may be cut short.
        """
        if again:
            self.line.write(flushing(request))
        self.line.drop_input()
        self.tell(request)
        end_s = self.clock.now_s() + timeout_s + _TEXT_S
        heard = part = self.line.read(1, timeout_s)
        while part and len(heard) < _LONGEST_TEXT and self.clock.now_s() < end_s:
            part = self.line.read(_TEXT_BYTES, _QUIET_S)
            heard += part
        return heard.decode("ascii", "replace")

    def _hear(self, expected: Wanted, timeout_s: float) -> Reply | None:
        deadline_s = self.clock.now_s() + timeout_s
        rest, missing = b"", expected.shortest
        while (left_s := deadline_s - self.clock.now_s()) > 0:
            part = self.line.read(missing, left_s)
            if not part:
                break
            search = find_reply(rest + part, expected)
            self.counts.corrupt += search.corrupt
            if search.reply:
                return search.reply
            rest, missing = search.rest, search.missing
        return None


def qbmove_ports() -> list[str]:
    """Ports behind an FTDI bridge, which other instruments have too; nothing is sent to them."""
    return [
        port.device for port in list_ports.comports() if port.vid == _FTDI_VENDOR or port.manufacturer == _MANUFACTURER
    ]


def answers(line: ByteLine, clock: Clock, ids: Sequence[int], reply_s: float) -> Iterator[str]:
    """Ping every id, or all where none is given, and tell who answers within ``reply_s``. About 3 s for all ids.

    SettingError : an id that no qbmove has."""
    talk = Conversation(line, clock)
    for device_id in ids_asked(ids, range(1, 256)):
        request = frame(device_id, Command.PING)
        reply = talk.ask(request, ping_reply(device_id), timeout_s=reply_s, attempts=_SCAN_ATTEMPTS)
        if reply:  # ten digits from firmware 7.1 on
            number = f", serial number {int.from_bytes(reply.payload):010d}" if reply.payload else ""
            yield f"id {device_id}{number}"
