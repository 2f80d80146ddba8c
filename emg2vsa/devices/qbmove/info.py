"""What a qbmove says about itself: the ASCII text of GET_INFO, ``infoPrepare`` in command_processing.c (v6.1), and the
list of its parameters, one slot of 50 bytes each, with type, count, values and a name."""

from __future__ import annotations

import re
import struct
from dataclasses import dataclass, field

from emg2vsa.devices.protocols import Parameter
from emg2vsa.devices.qbmove.settings import Model
from emg2vsa.errors import DeviceError


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
        """As the rig file names it: v6, v7."""
        found = re.search(r"v\d+", self.firmware)
        return found.group() if found else "unknown"


def parse_info(text: str, where: str) -> QbmoveInfo:
    """The text of GET_INFO, read. DeviceError at the first line that is absent."""

    def line(name: str, pattern: str) -> tuple[str, ...]:
        match = re.search(rf"^{re.escape(name)}{pattern}\s*$", text, re.MULTILINE)
        if match is None:
            heard = f"{len(text)} characters without it" if text else "nothing"
            raise DeviceError(
                f"{where}, info",
                wanted=f"a line '{name}: ...'",
                found=heard,
                do="Check power, baud rate and generation.",
            )
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


_MODELS: dict[str, Model] = {"QBMMP": "maker-pro", "QBADV": "advanced"}
"""First word of the firmware's version."""


def check_kind(info: QbmoveInfo, model: Model, where: str) -> None:
    """DeviceError unless the firmware is that of ``model``: the same ticks are another stiffness on the other one."""
    name = info.firmware.split()[0] if info.firmware.split() else ""
    if _MODELS.get(name) != model:
        of = _MODELS.get(name)
        do = f'Set model = "{of}", and export the schedules for it.' if of else "Check port and id: is it a qbmove?"
        wanted = f"firmware of the {model} that [actuator] model names"
        raise DeviceError(f"{where}, model", wanted=wanted, found=info.firmware or "no name", do=do)


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
            raise DeviceError(
                f"{where}, parameter {number}",
                wanted=f"a slot of type {min(FORMATS)} to {max(FORMATS)} within {SLOT_BYTES} bytes",
                found=f"{slot[:8].hex(' ')} ..." if slot else "the end of the list",
                do="Check the generation of the firmware.",
            )
        values = struct.unpack(f">{count}{FORMATS[kind]}", slot[2 : 2 + size])
        found[number] = Parameter(number, _name(slot[2 + size :]), values, FORMATS[kind])
    return found


def _name(text: bytes) -> str:
    return text.split(b":")[0].split(b"\0")[0].decode("ascii", "replace").partition(" - ")[2]
