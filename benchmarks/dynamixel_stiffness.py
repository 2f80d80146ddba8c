"""How far a stiffness that ``emg2vsa rig commission`` measures is from the emulated motor's own, and how often twice
its standard error holds that: ``python -m benchmarks.dynamixel_stiffness``, some minutes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np

from benchmarks.dynamixel_faults import D_GAIN, GEAR_MM_PER_DEGREE
from emg2vsa.devices.clock import VirtualClock
from emg2vsa.devices.dynamixel import DynamixelSettings
from emg2vsa.errors import DeviceError
from emg2vsa.rig.commissioning.checks import measure_stiffness
from emg2vsa.rig.commissioning.hand_motion import HandMotion
from emg2vsa.rig.rig_settings import RigSettings
from emg2vsa.worlds.bench.bench import EmulatedRig
from emg2vsa.worlds.bench.settings import EmulatedSettings
from emg2vsa.worlds.far_ends.dynamixel.table import XM430_W350

WORLDS = {"as emulated": (1.0, 1.0), "noise x 5": (5.0, 1.0), "friction x 2": (1.0, 2.0)}
"""Factors of the sensor's noise and of the gear's friction."""
SPECIMENS, GAINS, PRESETS = ("S1", "S3", "S5"), (400, 600, 800), (0.2, 0.5, 0.8)


def errors(noise: float, friction: float) -> Iterator[tuple[float, float] | None]:
    """Of each measurement: relative error, and error over standard error; None where it was refused."""
    for specimen, gain, preset in product(SPECIMENS, GAINS, PRESETS):
        clock, full = VirtualClock(), XM430_W350.stiffness_nm_per_rad(gain)
        motor = DynamixelSettings(kind="dynamixel", full_gain=gain, d_gain=D_GAIN, goal_current_a=0.6)
        rig = RigSettings(gear_mm_per_degree=GEAR_MM_PER_DEGREE, full_preset=full)
        emulated = EmulatedSettings(force_noise_n=noise * EmulatedSettings().force_noise_n)
        bench = EmulatedRig(emulated, specimen, 0, False, clock, rig=rig, actuator=motor)
        firmware: Any = bench.firmware
        model = firmware.motor.model
        firmware.motor.model = replace(model, friction_nm=friction * model.friction_nm)
        hand = HandMotion(bench.devices(), rig, clock)
        hand.start()
        try:
            found = measure_stiffness(hand, rig, preset, 0.0, 40.0, lambda _: None)
        except DeviceError:
            yield None
            continue
        true = full * round(preset * gain) / gain
        yield found.nm_per_rad / true - 1, (found.nm_per_rad - true) / found.se_nm_per_rad


def main() -> None:
    """Print a row for each world."""
    print("# Measured stiffness of an emulated Dynamixel\n")
    print("Made by `python -m benchmarks.dynamixel_stiffness`. No real motor was measured.\n")
    print("| world | measured | refused | mean error, % | worst, % | twice the standard error holds the truth |")
    print("|---|---|---|---|---|---|")
    for name, factors in WORLDS.items():
        found = list(errors(*factors))
        relative, scaled = np.array([each for each in found if each]).T
        held = np.count_nonzero(np.abs(scaled) < 2)
        print(
            f"| {name} | {scaled.size} | {found.count(None)} | {100 * relative.mean():+.1f} "
            f"| {100 * np.abs(relative).max():.1f} | {held} of {scaled.size} |",
            flush=True,
        )


if __name__ == "__main__":
    main()
