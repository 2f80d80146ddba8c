"""What may be asked of a qbmove: everything outside is refused, nothing is clipped.

The firmware itself clips positions, refuses to start and drops commands in silence (command_processing.c, v6.1), so the
driver asks only for what the device will do.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from emg2vsa.devices.qbmove.info import QbmoveInfo
from emg2vsa.errors import DeviceError

FULL_STIFFNESS = 32768
"""The stiffness of SET_POS_STIFF that would be the whole of max_stiffness."""
START_LIMIT_TICKS = 13000
"""cmd_activate: an encoder beyond this may have lost a rotation, and the motors stay off without a word."""
_INTERNAL_PER_TICK = 2
"""The firmware counts 65536 to the turn, the wire at resolution 1 half as many."""


@dataclass(frozen=True)
class QbmoveLimits:
    """Limits of one device in one study."""

    where: str
    info: QbmoveInfo
    stiffness_percent: tuple[float, float]
    "Of the device's maximum preset."

    def check_ready(self) -> None:
        """DeviceError unless position commands in wire ticks of 1/32768 turn will move the motors."""
        rules = (
            ("control mode", "Position", self.info.control_mode, "Set parameter 6 to 0 and store it."),
            ("input mode", "USB", self.info.input_mode, "Set parameter 5 to 0 and store it."),
            ("resolutions", (1, 1, 1), self.info.resolutions, "Set parameter 7 to 1, 1, 1 and store it."),
        )
        for name, wanted, found, do in rules:
            if wanted != found:
                raise DeviceError(f"{self.where}, {name}", wanted=str(wanted), found=str(found), do=do)
        if self.info.max_pwm_rate == 0:
            raise DeviceError(
                f"{self.where}, max PWM rate",
                wanted="above 0, or the motors never start a large move",
                found="0",
                do="Set parameter 14 and store it.",
            )

    def check_motor(self, motor: int, reference_ticks: int) -> None:
        """DeviceError when motor 1 or 2 would be sent outside its position limits."""
        low, high = self.info.position_limits_ticks[motor - 1]
        self._inside(f"reference of motor {motor}", reference_ticks, low, high, "ticks, the device's position limits")

    def check_position(self, position_ticks: int) -> None:
        """DeviceError outside the positions that leave room for full stiffness: the firmware clips to them."""
        low, high = self._positions
        self._inside("position", position_ticks, low, high, "ticks, at which every stiffness has room")

    def check_preset(self, preset_ticks: int) -> None:
        """DeviceError outside the study's range of stiffness."""
        low, high = self._presets
        if not low <= preset_ticks <= high:
            range_text = "ticks, {:g} to {:g} % of the device's maximum".format(*self.stiffness_percent)
            self._inside("stiffness preset", preset_ticks, low, high, range_text)

    @cached_property
    def _presets(self) -> tuple[int, int]:
        low, high = (round(percent / 100 * self.info.max_stiffness_ticks) for percent in self.stiffness_percent)
        return low, high

    @cached_property
    def _positions(self) -> tuple[int, int]:
        return roomy_positions(self.info)

    def _inside(self, what: str, value: int, low: int, high: int, text: str) -> None:
        if not low <= value <= high:
            do = "Correct the schedule, or the limits it was made for."
            raise DeviceError(f"{self.where}, {what}", wanted=f"{low} to {high} {text}", found=str(value), do=do)


def roomy_positions(info: QbmoveInfo) -> tuple[int, int]:
    """First and last position, ticks, that leaves room for full stiffness to both motors.

    The firmware clips to the limits of motor 1 alone, so motor 2's are kept here."""
    lows, highs = zip(*info.position_limits_ticks, strict=True)
    return max(lows) + info.max_stiffness_ticks, min(highs) - info.max_stiffness_ticks


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


def watchdog_on_wire(period_s: float) -> int:
    """The byte of SET_WATCHDOG, in steps of 20 ms."""
    return round(period_s * 50)
