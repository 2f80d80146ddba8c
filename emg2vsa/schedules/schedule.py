"""What a schedule is: force steps to stiffness, the ramp of the probe, the limits it keeps, where it comes from."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from emg2vsa.arrays import Floats
from emg2vsa.devices.joints import Export, export_of
from emg2vsa.devices.protocols import Joint

CONDITIONS = ("modular", "constant-min", "constant-mean", "constant-max")


def step_tolerance_n(width_n: float) -> float:
    """Largest difference of two force steps that count as equal: edges are rounded to 1e-9 N."""
    return 1e-6 * width_n + 2e-9


@dataclass(frozen=True)
class Ramp:
    """Linear ramp of the probe along the specimen's vertical axis, the position command of equation (8)."""

    speed_mm_per_s: float
    gear_mm_per_degree: float
    "Probe travel per degree of the output shaft."
    speed_deg_per_s: float
    travel_mm: float
    duration_s: float


@dataclass(frozen=True)
class Limits:
    """Limits of what the schedule may ask of which device.

    ``stiffness_percent`` are the ends of mapping (7), in percent of the device's maximum on ``scale``: "preset" or
    "stiffness" (N m/rad at zero load). ``full_preset`` is that of the joint ``actuator``, in its own unit.
    """

    stiffness_percent: tuple[float, float]
    full_preset: float
    actuator: str
    scale: str

    @cached_property
    def joint(self) -> Joint:
        """Joint that the presets are for. ScheduleError for a name that no joint has."""
        return self.export.joint(self.actuator, self.full_preset)

    @property
    def export(self) -> Export:
        """How its files state presets. ScheduleError for a name that no joint has."""
        return export_of(self.actuator, "limits.actuator")

    def preset_percent(self, percent_on_scale: Floats) -> Floats:
        """Percent of the maximum on ``scale`` (any shape) to percent of the maximum preset. A preset is that of
        equation (8)."""
        if self.scale == "preset":
            return percent_on_scale
        return self.joint.percent_for(percent_on_scale / 100 * self.joint.stiffness_nm_per_rad(1.0))


@dataclass(frozen=True, eq=False)
class Schedule:
    """One specimen under one condition: K force steps, each with the stiffness to hold while force is in it."""

    specimen: str
    condition: str
    "modular, or constant at the min, mean or max of the profile"
    step_force_n: Floats
    "(K + 1,) edges of the force steps."
    stiffness_percent: Floats
    "(K,) percent of the maximum preset, before rounding to what the device can be sent."
    preset: Floats
    "(K,) share of the maximum preset, 0 to 1, as the device is sent it."
    stiffness_nm_per_rad: Floats
    "(K,) stiffness of those presets at zero load, by the model of the joint."
    activity_v: Floats
    "(K,) mean co-contraction that is mapped."
    last_step_short: bool
    ramp: Ramp
    limits: Limits
    provenance: dict[str, str]
    interval_percent: Floats | None = None
    "(2, K) low and high of ``stiffness_percent``; None: not known. Of what, ``provenance`` says under ``interval``."

    @property
    def interval(self) -> Floats:
        """(2, K) low and high of ``stiffness_percent``; NaN where it is not known."""
        return np.full((2, self.preset.size), np.nan) if self.interval_percent is None else self.interval_percent

    @property
    def exported(self) -> np.ndarray[tuple[int], np.dtype[np.generic]]:
        """(K,) presets in the unit of the schedule's files (qbmove: whole ticks). A preset is that of equation (8)."""
        export, full = self.limits.export, self.limits.full_preset
        return np.array([export.exported(share * full) for share in self.preset.tolist()])

    def __repr__(self) -> str:
        low, high = self.stiffness_percent.min(), self.stiffness_percent.max()
        span = f"{self.step_force_n[0]:g} to {self.step_force_n[-1]:g} N"
        steps = f"{low:.3g} to {high:.3g} % in {self.preset.size} steps"
        return f"Schedule({self.specimen} {self.condition}: {steps}, {span})"
