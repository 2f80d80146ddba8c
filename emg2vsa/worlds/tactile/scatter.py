"""In what presses of one sensor differ although they were meant to be alike."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

from casr.errors import SettingError
from emg2vsa.worlds.tactile.draws import Draws


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
            value = getattr(self, each.name)
            most = 5.0 if each.name == "angle_sd_deg" else 0.1
            if not 0 <= value <= most:
                raise SettingError(
                    f"scatter, {each.name}", wanted=f"a number from 0 to {most:g}", found=repr(value),
                    do="Correct the scatter.",
                )  # fmt: skip

    def drawn(self, draws: Draws) -> Drawn:
        """What is drawn for one press."""
        depth, stiffness, angle = (float(draws.of_mounting(what).standard_normal()) for what in draws.mounted)
        area, zero, latency = draws.of("scatter").standard_normal(3).tolist()
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
