"""What a simulated press is made from: its settings, and random numbers that belong to it alone.

Any press can be made again without the others.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, fields

import numpy as np

from casr.camera import Camera, Sensor
from casr.specimens import SPECIMENS
from emg2vsa.worlds.tactile.appearance import TACTIP_127, Appearance, Skin
from emg2vsa.worlds.tactile.tabulated import TabulatedWorld
from emg2vsa.worlds.tactile.world import World, check

MOUNTED = ("depth", "stiffness", "angle")
"What a mounting fixes."
_STREAMS = ("sensor", "centre", "brightness", "timing", "force", "frame", "scatter", "jitter")
_FIRST_OF_MOUNTING = 100
"Key of the first thing that a mounting draws, away from those of the streams."


@dataclass(frozen=True, kw_only=True)
class Scatter:
    """Standard deviations of normal draws; the defaults draw nothing, ``REALISTIC`` is that of a good bench.

    Parameters
    ----------
    depth_sd : relative, of the camera's true depth about that in camera.toml; all presses of a mounting share it.
    stiffness_sd : relative, of a specimen; all its presses of a mounting share it.
    angle_sd_deg : of a specimen at an angle; all its presses of a mounting share it.
    area_sd : relative, of the contact's area at a force, press by press: the skin is uneven.
    force_zero_sd_n : of what the force sensor reads at rest, press by press.
    latency_sd_s, jitter_sd_s : of the time from exposure to the log's count of the frame, press by press and frame by
        frame, about a mean that is known.
    """

    depth_sd: float = 0.0
    stiffness_sd: float = 0.0
    angle_sd_deg: float = 0.0
    area_sd: float = 0.0
    force_zero_sd_n: float = 0.0
    latency_sd_s: float = 0.0
    jitter_sd_s: float = 0.0

    def __post_init__(self) -> None:
        for each in fields(self):
            value, most = getattr(self, each.name), 5.0 if each.name == "angle_sd_deg" else 0.1
            wanted = f"a number from 0 to {most:g}"
            check(0 <= value <= most, f"scatter, {each.name}", wanted, repr(value), "Correct the scatter.")

    def drawn(self, press: PressSettings) -> Drawn:
        """What is drawn for one press."""
        depth, stiffness, angle = (float(press.draws_of_mounting(what).standard_normal()) for what in MOUNTED)
        area, zero, latency = press.draws("scatter").standard_normal(3).tolist()
        return Drawn(
            depth=math.exp(self.depth_sd * depth),
            stiffness=math.exp(self.stiffness_sd * stiffness),
            angle_deg=self.angle_sd_deg * angle,
            area=math.exp(self.area_sd * area),
            force_zero_n=self.force_zero_sd_n * zero,
            latency_s=self.latency_sd_s * latency,
        )


REALISTIC = Scatter(
    depth_sd=0.01, stiffness_sd=0.02, angle_sd_deg=0.5, area_sd=0.015, force_zero_sd_n=0.02, latency_sd_s=0.005,
    jitter_sd_s=0.005,
)  # fmt: skip
"A depth sensor, cast specimens, a dial for the angle, a USB camera (guesses; cameras and force sensors: data sheets)."


@dataclass(frozen=True, kw_only=True)
class Drawn:
    """A press against what was meant. depth, stiffness, area : factors. angle_deg, force_zero_n, latency_s : added."""

    depth: float = 1.0
    stiffness: float = 1.0
    angle_deg: float = 0.0
    area: float = 1.0
    force_zero_n: float = 0.0
    latency_s: float = 0.0


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
        check(
            0 < self.start_n < self.peak_n < math.inf, "start_n, peak_n",
            f"a peak force above the {self.start_n:g} N at which loading starts, both above 0",
            f"{self.peak_n:g} N", "Press harder.",
        )  # fmt: skip
        times = (self.loading_s, self.rounding_s, self.unloading_s, self.log_rate_hz)
        shares_fit = 0 <= self.force_noise_n < math.inf and 0 <= self.speed_share < 1
        check(
            all(0 < time < math.inf for time in times) and self.rest_frames >= 1 and shares_fit, "timeline",
            "times and rates above 0, a rest frame or more, noise of 0 or more, speed_share below 1",
            repr(self), "Correct the timeline.",
        )  # fmt: skip
        wanted = f"at most half of loading_s, {self.loading_s / 2:g} s"
        fits = self.rounding_s <= self.loading_s / 2
        check(fits, "rounding_s", wanted, f"{self.rounding_s:g} s", "Round the ends less.")


SIMULATED_SENSOR = Sensor(pin_length_mm=3.0, dome_radius_mm=20.0)


@dataclass(frozen=True, kw_only=True)
class PressSettings:
    """One press; equal settings give equal bytes.

    Parameters
    ----------
    stiffness_n_per_mm : of the specimen by plate indentation; see ``SPECIMENS``.
    specimen_height_mm : where the tables of the world are of several heights.
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
    specimen_height_mm: float | None = None
    world: World = field(default_factory=TabulatedWorld)
    skin: Skin = TACTIP_127
    camera: Camera = field(default_factory=lambda: Camera(sensor=SIMULATED_SENSOR))
    appearance: Appearance = field(default_factory=Appearance)
    timeline: TimelineSettings = field(default_factory=TimelineSettings)

    def __post_init__(self) -> None:
        check(
            0 < self.stiffness_n_per_mm < math.inf and 0 <= self.angle_deg < 90 and 0 <= self.centre_sd_mm < 5,
            "stiffness_n_per_mm, angle_deg, centre_sd_mm",
            "a stiffness above 0, an angle from 0 to below 90 degrees, a spread from 0 to below 5 mm",
            f"{self.stiffness_n_per_mm!r}, {self.angle_deg!r}, {self.centre_sd_mm!r}", "Correct the press.",
        )  # fmt: skip
        numbers = (self.seed, self.repetition, self.mounting)
        found = ", ".join(map(str, numbers))
        check(min(numbers) >= 0, "seed, repetition, mounting", "numbers of 0 or more", found, "Choose other numbers.")

    def draws(self, stream: str, *number: int) -> np.random.Generator:
        """For one of ``_STREAMS`` of this press; ``frame`` takes its number."""
        return _generator((self.seed, *self._specimen, self.repetition), (_STREAMS.index(stream), *number))

    def draws_of_mounting(self, what: str) -> np.random.Generator:
        """For what all presses of this mounting share; a depth with all specimens, an angle with this specimen's."""
        which = MOUNTED.index(what)
        return _generator((self.seed, self.mounting, *self._specimen[:which]), (_FIRST_OF_MOUNTING + which,))

    def draws_of_sensor(self) -> np.random.Generator:
        """For what all presses of one sensor share: dirt, texture, missing pins."""
        return _generator(self.seed, (0,))

    @property
    def _specimen(self) -> tuple[int, int]:
        return round(self.stiffness_n_per_mm * 1000), round(self.angle_deg * 1000)


def _generator(entropy: int | tuple[int, ...], key: tuple[int, ...]) -> np.random.Generator:
    return np.random.default_rng(np.random.SeedSequence(entropy, spawn_key=key))
