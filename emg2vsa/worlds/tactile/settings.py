"""What a simulated press is made from."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from casr.camera import Camera, Sensor
from casr.errors import SettingError
from casr.specimens import SPECIMENS
from emg2vsa.worlds.tactile.appearance import Appearance
from emg2vsa.worlds.tactile.scatter import Drawn, Scatter
from emg2vsa.worlds.tactile.skin import TACTIP_127, Skin
from emg2vsa.worlds.tactile.tabulated import TabulatedWorld
from emg2vsa.worlds.tactile.world import World


@dataclass(frozen=True, kw_only=True)
class TimelineSettings:
    """Force over time and how it is logged.

    Parameters
    ----------
    start_n, peak_n : forces between which the press counts as loading (paper: 0.5 to 7 N).
    loading_s : from ``start_n`` to ``peak_n`` at constant rate.
    rounding_s : time in which the rate builds up before the press and fades before the peak, each.
    unloading_s : from the peak back to 0.
    rest_frames : frames before the force rises.
    log_rate_hz : of the force log.
    force_noise_n : standard deviation of the noise of each row.
    speed_share : loading is up to this share faster or slower from repetition to repetition.
    """

    start_n: float = 0.5
    peak_n: float = 7.0
    loading_s: float = 3.0
    rounding_s: float = 0.1
    unloading_s: float = 0.35
    rest_frames: int = 4
    log_rate_hz: float = 200.0
    force_noise_n: float = 0.01
    speed_share: float = 0.05

    def __post_init__(self) -> None:
        if not 0 < self.start_n < self.peak_n < math.inf:
            raise SettingError(
                "start_n, peak_n",
                wanted=f"a peak force above the {self.start_n:g} N at which loading starts, both above 0",
                found=f"{self.peak_n:g} N",
                do="Press harder.",
            )
        times = (self.loading_s, self.rounding_s, self.unloading_s, self.log_rate_hz)
        shares_fit = 0 <= self.force_noise_n < math.inf and 0 <= self.speed_share < 1
        if not (all(0 < time < math.inf for time in times) and self.rest_frames >= 1 and shares_fit):
            raise SettingError(
                "timeline",
                wanted="times and rates above 0, a rest frame or more, noise of 0 or more, speed_share below 1",
                found=repr(self),
                do="Correct the timeline.",
            )
        if self.rounding_s > self.loading_s / 2:
            raise SettingError(
                "rounding_s",
                wanted=f"at most half of loading_s, {self.loading_s / 2:g} s",
                found=f"{self.rounding_s:g} s",
                do="Round the ends less.",
            )


SIMULATED_SENSOR = Sensor(pin_length_mm=3.0, dome_radius_mm=20.0)


@dataclass(frozen=True, kw_only=True)
class PressSettings:
    """One press; equal settings give equal bytes.

    Parameters
    ----------
    stiffness_n_per_mm : of the specimen by plate indentation; see ``SPECIMENS``.
    angle_deg : between the sensor's axis and the normal of the specimen's surface; the contact moves along +x.
    repetition, seed : which of the presses of the sensor ``seed``.
    mounting : which of the times that sensor and specimens were mounted.
    scatter : in what presses differ from what was meant. drawn : in what this one does, instead of a draw.
    centre_sd_mm : standard deviation of where the contact lands, along x and y; never more than twice that far.
    """

    stiffness_n_per_mm: float = SPECIMENS["S3"]
    angle_deg: float = 0.0
    repetition: int = 0
    seed: int = 0
    mounting: int = 0
    scatter: Scatter = field(default_factory=Scatter)
    drawn: Drawn | None = None
    centre_sd_mm: float = 0.5
    world: World = field(default_factory=TabulatedWorld)
    skin: Skin = TACTIP_127
    camera: Camera = field(default_factory=lambda: Camera(sensor=SIMULATED_SENSOR))
    appearance: Appearance = field(default_factory=Appearance)
    timeline: TimelineSettings = field(default_factory=TimelineSettings)

    def __post_init__(self) -> None:
        if not (0 < self.stiffness_n_per_mm < math.inf and 0 <= self.angle_deg < 90 and 0 <= self.centre_sd_mm < 5):
            raise SettingError(
                "stiffness_n_per_mm, angle_deg, centre_sd_mm",
                wanted="a stiffness above 0, an angle from 0 to below 90 degrees, a spread from 0 to below 5 mm",
                found=f"{self.stiffness_n_per_mm!r}, {self.angle_deg!r}, {self.centre_sd_mm!r}",
                do="Correct the press.",
            )
