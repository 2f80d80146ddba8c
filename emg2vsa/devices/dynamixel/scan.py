"""Who is on the line: the ids that answer a ping of protocol 2.0."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from emg2vsa.devices.addresses import ids_asked
from emg2vsa.devices.clock import Clock
from emg2vsa.devices.dynamixel.conversation import Conversation
from emg2vsa.devices.dynamixel.info import model_named
from emg2vsa.devices.serial_line import ByteLine

_ATTEMPTS = 2


def answers(line: ByteLine, clock: Clock, ids: Sequence[int], reply_s: float) -> Iterator[str]:
    """Ping every id, or all where none is given, and tell who answers within ``reply_s``. About 3 s for all ids.

    A motor that is set to another baud rate than the line, or to protocol 1.0, does not answer.

    SettingError : an id that no motor has."""
    talk = Conversation(line, clock, reply_s)
    for device_id in ids_asked(ids, range(253)):
        if answer := talk.ping(device_id, _ATTEMPTS):
            number, firmware = answer
            yield f"id {device_id}, {model_named(number) or f'model {number}'}, firmware {firmware}"
