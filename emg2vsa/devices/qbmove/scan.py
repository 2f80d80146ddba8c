"""Who is on the line: serial ports that may lead to qbmoves, and the ids that answer."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from serial.tools import list_ports

from emg2vsa.devices.addresses import ids_asked
from emg2vsa.devices.clock import Clock
from emg2vsa.devices.qbmove.conversation import Conversation
from emg2vsa.devices.qbmove.packets import Command, frame, ping_reply
from emg2vsa.devices.serial_line import ByteLine

_FTDI_VENDOR = 0x0403
_MANUFACTURER = "QB Robotics"
_ATTEMPTS = 2


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
        reply = talk.ask(request, ping_reply(device_id), timeout_s=reply_s, attempts=_ATTEMPTS)
        if reply:  # ten digits from firmware 7.1 on
            number = f", serial number {int.from_bytes(reply.payload):010d}" if reply.payload else ""
            yield f"id {device_id}{number}"
