"""What a qbmove says about itself, and what may be asked of it.

It says the ASCII text of GET_INFO, ``infoPrepare`` in command_processing.c (v6.1), and the list of its parameters, one
slot of 50 bytes each, with type, count, values and a name. The firmware itself clips positions, refuses to start and
drops commands in silence, so the driver asks only for what the device will do: everything outside is refused, nothing
is clipped.
"""

from __future__ import annotations

import math
import re
import struct
from dataclasses import dataclass, field
from functools import cached_property, lru_cache

import numpy as np

from emg2vsa.devices.protocols import Parameter
from emg2vsa.devices.qbmove import Model
from emg2vsa.errors import DeviceError

FULL_STIFFNESS = 32768
"""The stiffness of SET_POS_STIFF that would be the whole of max_stiffness."""
START_LIMIT_TICKS = 13000
"""cmd_activate: an encoder beyond this may have lost a rotation, and the motors stay off without a word."""
_INTERNAL_PER_TICK = 2
"""The firmware counts 65536 to the turn, the wire at resolution 1 half as many."""
_MODELS: dict[str, Model] = {"QBMMP": "maker-pro", "QBADV": "advanced"}
"""First word of the firmware's version."""


@dataclass(frozen=True)
class QbmoveInfo:
    """The lines of the text that a run depends on. Ticks are wire ticks."""

    firmware: str
    device_id: int
    max_stiffness_ticks: int
    "Preset at full stiffness, q1 - q2 over 2: of this very device, found by its calibration."
    position_limits_ticks: tuple[tuple[int, int], tuple[int, int]]
    "(lowest, highest) of motor 1 and of motor 2."
    resolutions: tuple[int, int, int]
    control_mode: str
    input_mode: str
    current_limit_ma: int
    max_pwm_rate: int | None
    "None where the firmware has no such parameter."
    voltage_mv: int = field(compare=False)

    @property
    def generation(self) -> str:
        """Generation as the rig file names it: v6, v7."""
        found = re.search(r"v\d+", self.firmware)
        return found.group() if found else "unknown"

    @property
    def roomy_ticks(self) -> tuple[int, int]:
        """First and last position that leaves room for full stiffness to both motors.

        The firmware clips to the limits of motor 1 alone, so motor 2's are kept here."""
        lows, highs = zip(*self.position_limits_ticks, strict=True)
        return max(lows) + self.max_stiffness_ticks, min(highs) - self.max_stiffness_ticks

    def check_model(self, model: Model, where: str) -> None:
        """DeviceError unless the firmware is that of ``model``: the same ticks are another stiffness on the other."""
        of = _MODELS.get((self.firmware.split() or [""])[0])
        if of != model:
            do = f'Set model = "{of}", and export the schedules for it.' if of else "Check port and id: is it a qbmove?"
            wanted = f"firmware of the {model} that [actuator] model names"
            raise DeviceError(f"{where}, model", wanted=wanted, found=self.firmware or "no name", do=do)


def parse_info(text: str, where: str) -> QbmoveInfo:
    """The text of GET_INFO, read. DeviceError at the first line that is absent."""

    def line(name: str, pattern: str) -> tuple[str, ...]:
        match = re.search(rf"^{re.escape(name)}{pattern}\s*$", text, re.MULTILINE)
        if match is None:
            heard = f"{len(text)} characters without it" if text else "nothing"
            do = "Check power, baud rate and generation."
            raise DeviceError(f"{where}, info", wanted=f"a line '{name}: ...'", found=heard, do=do)
        return match.groups()

    def number(name: str) -> int:
        return int(line(name, r": (-?\d+)")[0])

    limits = [tuple(map(int, line(f"Position limit motor {k}", r": inf -> (-?\d+)  sup -> (-?\d+)"))) for k in (1, 2)]
    resolutions = line("Sensor resolution", r":\s+1 -> (\d+)\s+2 -> (\d+)\s+3 -> (\d+)")
    return QbmoveInfo(
        firmware=line("Firmware version", r": (.*?)\.")[0],
        device_id=number("ID"),
        max_stiffness_ticks=number("Max stiffness"),
        position_limits_ticks=((limits[0][0], limits[0][1]), (limits[1][0], limits[1][1])),
        resolutions=(int(resolutions[0]), int(resolutions[1]), int(resolutions[2])),
        control_mode=line("Control Mode", r": (\w[\w ]*)")[0],
        input_mode=line("Input mode", r": (\w[\w ]*)")[0],
        current_limit_ma=number("Current limit"),
        max_pwm_rate=number("Max pwm rate") if "Max pwm rate" in text else None,
        voltage_mv=number("Voltage (mV)"),
    )


SLOT_BYTES = 50
FORMATS = {0: "B", 1: "b", 2: "B", 3: "h", 4: "H", 5: "i", 6: "I", 7: "f", 8: "d"}
"""Type byte to ``struct`` format: flag, then the integers by growing size, float and double."""


def decode_parameters(payload: bytes, where: str) -> dict[int, Parameter]:
    """The payload of the list, after its command byte, by number from 1. DeviceError for a slot that makes no sense."""
    found = {}
    for number in range(1, payload[0] + 1):
        slot = payload[1 + SLOT_BYTES * (number - 1) :][:SLOT_BYTES]
        kind, count = slot[:2] if len(slot) >= 2 else (None, 0)
        size = struct.calcsize(f">{count}{FORMATS[kind]}") if kind in FORMATS else SLOT_BYTES
        if kind is None or 2 + size > len(slot):
            wanted = f"a slot of type {min(FORMATS)} to {max(FORMATS)} within {SLOT_BYTES} bytes"
            found_text = f"{slot[:8].hex(' ')} ..." if slot else "the end of the list"
            do = "Check the generation of the firmware."
            raise DeviceError(f"{where}, parameter {number}", wanted=wanted, found=found_text, do=do)
        values = struct.unpack(f">{count}{FORMATS[kind]}", slot[2 : 2 + size])
        found[number] = Parameter(number, _name(slot[2 + size :]), values, FORMATS[kind])
    return found


def _name(text: bytes) -> str:
    return text.split(b":")[0].split(b"\0")[0].decode("ascii", "replace").partition(" - ")[2]


@dataclass(frozen=True)
class QbmoveLimits:
    """Limits of one device in one study."""

    where: str
    info: QbmoveInfo
    stiffness_percent: tuple[float, float]
    "Range of stiffness, percent of the device's maximum preset."

    def check_ready(self) -> None:
        """DeviceError unless position commands in wire ticks of 1/32768 turn will move the motors."""
        info, moves = self.info, "above 0, or the motors never start a large move"
        for name, wanted, found, good, do in (
            ("control mode", "Position", info.control_mode, info.control_mode == "Position", "Set parameter 6 to 0"),
            ("input mode", "USB", info.input_mode, info.input_mode == "USB", "Set parameter 5 to 0"),
            ("resolutions", "(1, 1, 1)", info.resolutions, info.resolutions == (1, 1, 1), "Set parameter 7 to 1, 1, 1"),
            ("max PWM rate", moves, info.max_pwm_rate, info.max_pwm_rate != 0, "Set parameter 14"),
        ):
            if not good:
                raise DeviceError(f"{self.where}, {name}", wanted=wanted, found=str(found), do=f"{do} and store it.")

    def check_motor(self, motor: int, reference_ticks: int) -> None:
        """DeviceError when motor 1 or 2 would be sent outside its position limits."""
        limits, text = self.info.position_limits_ticks[motor - 1], "ticks, the device's position limits"
        self._inside(f"reference of motor {motor}", reference_ticks, limits, text)

    def check_position(self, position_ticks: int) -> None:
        """DeviceError outside the positions that leave room for full stiffness: the firmware clips to them."""
        self._inside("position", position_ticks, self._roomy_ticks, "ticks, at which every stiffness has room")

    def check_preset(self, preset_ticks: int) -> None:
        """DeviceError outside the study's range of stiffness."""
        self._inside("stiffness preset", preset_ticks, *self._presets)

    @cached_property
    def _roomy_ticks(self) -> tuple[int, int]:
        return self.info.roomy_ticks

    @cached_property
    def _presets(self) -> tuple[tuple[int, int], str]:
        low, high = (round(percent / 100 * self.info.max_stiffness_ticks) for percent in self.stiffness_percent)
        return (low, high), "ticks, {:g} to {:g} % of the device's maximum".format(*self.stiffness_percent)

    def _inside(self, what: str, value: int, limits: tuple[int, int], text: str) -> None:
        if not limits[0] <= value <= limits[1]:
            wanted, do = f"{limits[0]} to {limits[1]} {text}", "Correct the schedule, or the limits it was made for."
            raise DeviceError(f"{self.where}, {what}", wanted=wanted, found=str(value), do=do)


@lru_cache
def stiffness_on_wire(preset_ticks: int, max_stiffness_ticks: int) -> int:
    """The stiffness of SET_POS_STIFF for which the firmware comes to this very preset, 0 to max_stiffness_ticks - 1.

    The firmware truncates max/32768 x stiffness in single precision to its internal ticks, half a wire tick each.
    """
    most = np.float32(max_stiffness_ticks * _INTERNAL_PER_TICK)
    stiffness = math.ceil(preset_ticks * FULL_STIFFNESS / max_stiffness_ticks)
    if int(most / np.float32(FULL_STIFFNESS) * np.float32(stiffness)) < preset_ticks * _INTERNAL_PER_TICK:
        stiffness += 1
    return stiffness
