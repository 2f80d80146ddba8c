"""What may be asked of a qbmove, and the stiffness on the wire that its firmware maps to the preset meant."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from emg2vsa.devices.qbmove.info import QbmoveInfo, QbmoveLimits, stiffness_on_wire
from emg2vsa.errors import DeviceError

INFO = QbmoveInfo(
    "QBMMP v6.1.0", 1, 3000, ((-15000, 15000), (-14000, 14000)), (1, 1, 1), "Position", "USB", 1500, None, 24000
)
LIMITS = QbmoveLimits("line", INFO, (20.0, 80.0))


@pytest.mark.parametrize("most", [1, 37, 2874, 3000, 4096, 8000, 15000])
def test_every_preset_below_the_maximum_comes_out_to_the_tick(most: int) -> None:
    # the firmware: max_stiffness / 32768.0 * stiffness in single precision, truncated to internal ticks
    internal = np.float32(2 * most) / np.float32(32768)
    for preset in range(most):
        stiffness = stiffness_on_wire(preset, most)
        assert stiffness <= 32767
        assert int(internal * np.float32(stiffness)) >> 1 == preset


def test_the_example_of_the_protocol() -> None:
    assert stiffness_on_wire(1500, 3000) == 16384


@pytest.mark.parametrize("preset", [600, 1500, 2400])
def test_presets_of_the_study_pass(preset: int) -> None:
    LIMITS.check_preset(preset)


@pytest.mark.parametrize("preset", [-600, 0, 599, 2401, 3000])
def test_presets_outside_are_refused_and_not_clipped(preset: int) -> None:
    with pytest.raises(
        DeviceError,
        match=r"600 to 2400 ticks, 20 to 80 % of the device's maximum, but found "
        rf"{preset}\.",
    ):
        LIMITS.check_preset(preset)


def test_positions_that_the_firmware_would_clip_are_refused() -> None:
    # motor 2's limits, -14000 to 14000, are the narrower ones; the firmware would keep those of motor 1 only
    LIMITS.check_position(11000)
    LIMITS.check_position(-11000)
    for position in (11001, -11001):
        with pytest.raises(DeviceError, match="-11000 to 11000 ticks"):
            LIMITS.check_position(position)


def test_each_motor_has_its_own_limits() -> None:
    LIMITS.check_motor(1, 15000)
    with pytest.raises(DeviceError, match="reference of motor 2: expected -14000 to 14000"):
        LIMITS.check_motor(2, 15000)


@pytest.mark.parametrize(
    ("changed", "named"),
    [
        ({"control_mode": "PWM"}, "control mode: expected Position, but found PWM"),
        ({"input_mode": "Sensor 3"}, "input mode: expected USB"),
        ({"resolutions": (1, 1, 2)}, "resolutions"),
        ({"max_pwm_rate": 0}, "max PWM rate"),
    ],
)
def test_a_device_that_would_not_obey_is_not_ready(changed: dict[str, object], named: str) -> None:
    LIMITS.check_ready()
    with pytest.raises(DeviceError, match=named):
        replace(LIMITS, info=replace(INFO, **changed)).check_ready()
