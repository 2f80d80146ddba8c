"""A qbmove of generation 7, as its public client (qbrobotics_driver 7.2.8) expects it; the firmware is not public.

Where only the client is known, the rest is taken from generation 6: commands, slots of parameters, text of GET_INFO.
"""

from __future__ import annotations

import copy
from dataclasses import replace

from emg2vsa.devices.qbmove.packets import Command, frame, lrc
from emg2vsa.worlds.far_ends.qbmove.firmware import DONE, QbmoveFirmware
from emg2vsa.worlds.far_ends.qbmove.memory import ADVANCED, MAKER_PRO, parameter_list

# a PWM rate at which motors do move is a guess
MAKER_PRO_V7 = replace(MAKER_PRO, version="QBMMP v7.1.0", parameters=14, max_pwm_rate=10)
ADVANCED_V7 = replace(
    ADVANCED, version="QBADV v7.1.0", counts_backwards=False, position_gains=(0.1, 0.0, 0.8), max_pwm_rate=10
)
LONG_UNIT = 32
"""LEN of long replies counts as many bytes."""
SERIAL_NUMBER = 0x00980001


class QbmoveFirmwareV7(QbmoveFirmware):
    """Acknowledgements name their command, parameters act at once, long replies are framed."""

    def _acknowledge(self, command: int, device_id: int) -> bytes:
        return frame(device_id, command, bytes((DONE,)))

    def _ping(self) -> bytes:
        return self._reply(Command.PING, SERIAL_NUMBER.to_bytes(4))

    def _set_zeros(self) -> bytes:
        """No payload: zero is where everything stands."""
        seen = self._loop.motors.measured(self._shadow)
        self._shadow.offsets = [offset - at for offset, at in zip(self._shadow.offsets, seen, strict=True)]
        self._loop.motors.forget_turns(self._shadow)
        return self._acknowledge(Command.SET_ZEROS, self._shadow.device_id)

    def _parameter(self) -> bytes:
        (index,) = self._words(1)
        if index == 0:
            return self._long(Command.GET_PARAM_LIST, parameter_list(self._current, self._switches.parameters, 1151))
        if not 0 < index <= self._switches.parameters:
            return b""
        self._set_parameter(index)
        self._current = copy.deepcopy(self._shadow)
        return self._acknowledge(Command.GET_PARAM_LIST, self._shadow.device_id)

    def _info(self) -> bytes:
        return self._long(Command.GET_INFO, super()._info())

    def _long(self, command: Command, payload: bytes) -> bytes:
        """Command, payload and checksum, filled with zeros to whole units."""
        units = -(-(len(payload) + 2) // LONG_UNIT)
        body = (bytes((command,)) + payload).ljust(units * LONG_UNIT - 1, b"\0")
        return b"::" + bytes((self._shadow.device_id, units)) + body + bytes((lrc(body),))
