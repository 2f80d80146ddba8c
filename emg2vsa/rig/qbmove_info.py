"""What a qbmove says about itself: the ASCII text of GET_INFO, ``infoPrepare`` in command_processing.c (v6.1)."""

from __future__ import annotations

import re
from dataclasses import dataclass, field

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
    text: str = field(compare=False, repr=False)


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
        text=text,
    )
