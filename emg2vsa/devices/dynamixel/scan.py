"""Who is on the line: the ids that answer a ping of protocol 2.0."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from emg2vsa.devices.clock import Clock
from emg2vsa.devices.dynamixel.conversation import Conversation
from emg2vsa.devices.dynamixel.info import model_named
from emg2vsa.devices.serial_line import ByteLine

_ATTEMPTS = 2


@dataclass(frozen=True)
class FoundDynamixel:
    """A motor that has answered."""

    line: str
    device_id: int
    model: str
    "Name, or number where the driver does not know the model."
    firmware: int


def scan(
    line: ByteLine, clock: Clock, ids: Iterable[int] = range(253), *, reply_s: float = 0.005
) -> list[FoundDynamixel]:
    """Ping every id and list who answers within ``reply_s``. About 3 s for all ids. A motor that is set to another
    baud rate than the line, or to protocol 1.0, does not answer."""
    talk = Conversation(line, clock, reply_s)
    answers = ((device_id, talk.ping(device_id, _ATTEMPTS)) for device_id in ids)
    return [
        FoundDynamixel(line.name, device_id, model_named(answer[0]) or f"model {answer[0]}", answer[1])
        for device_id, answer in answers
        if answer
    ]
