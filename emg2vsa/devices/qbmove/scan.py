"""Who is on the line: serial ports that may lead to qbmoves, and the ids that answer."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from serial.tools import list_ports

from emg2vsa.devices.clock import Clock
from emg2vsa.devices.qbmove.conversation import Conversation
from emg2vsa.devices.qbmove.packets import Command, frame, ping_reply
from emg2vsa.devices.serial_line import ByteLine

_FTDI_VENDOR = 0x0403
_MANUFACTURER = "QB Robotics"
_ATTEMPTS = 2


@dataclass(frozen=True)
class FoundQbmove:
    """A device that has answered."""

    line: str
    device_id: int
    serial_number: str
    "Ten digits, from firmware 7.1 on; else empty."


def qbmove_ports() -> list[str]:
    """Ports behind an FTDI bridge, which other instruments have too; nothing is sent to them."""
    return [
        port.device for port in list_ports.comports() if port.vid == _FTDI_VENDOR or port.manufacturer == _MANUFACTURER
    ]


def scan(
    line: ByteLine, clock: Clock, ids: Iterable[int] = range(1, 256), *, reply_s: float = 0.005
) -> list[FoundQbmove]:
    """Ping every id and list who answers within ``reply_s``. About 3 s for all ids."""
    talk = Conversation(line, clock)
    found = []
    for device_id in ids:
        request = frame(device_id, Command.PING)
        reply = talk.ask(request, ping_reply(device_id), timeout_s=reply_s, attempts=_ATTEMPTS)
        if reply:
            number = f"{int.from_bytes(reply.payload):010d}" if reply.payload else ""
            found.append(FoundQbmove(line.name, device_id, number))
    return found
