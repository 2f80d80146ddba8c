"""A simulated press as a camera sees it: few frames, each a little late, with forces and areas a little off."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from emg2vsa.arrays import Floats
from emg2vsa.worlds.contact.press_path import PressPaths


@dataclass(frozen=True, kw_only=True)
class FrameErrors:
    """Standard deviations of normal errors; 0 is none.

    area_share : of the area of a frame, as a share. force_n : of the force of a frame.
    latency_s : mean delay of frames that nobody corrects; latency_sd_s : of it from press to press.
    jitter_s : from frame to frame.
    """

    area_share: float = 0.0
    force_n: float = 0.0
    latency_s: float = 0.0
    latency_sd_s: float = 0.0
    jitter_s: float = 0.0


def frames_of(
    paths: PressPaths,
    press: int,
    first_s: Floats,
    errors: FrameErrors,
    rng: np.random.Generator,
    *,
    rate_hz: float = 20.0,
    window_n: tuple[float, float] = (0.5, 7.0),
) -> tuple[Floats, Floats]:
    """(D, T) forces and areas of the frames of a press seen D times; NaN where the force is outside the window.

    The first frame of each comes ``first_s`` (D,) after contact. A frame shows the contact as it was before its time
    stamp by the delay.
    """
    known = np.isfinite(paths.force_n[:, press])
    time_s, force, area = paths.time_s[known], paths.force_n[known, press], paths.area_mm2[known, press]
    stamps_s = first_s[:, None] + np.arange(math.ceil(time_s[-1] * rate_hz)) / rate_hz
    late_s = errors.latency_s + rng.normal(0, errors.latency_sd_s, (first_s.size, 1))
    late_s = late_s + rng.normal(0, errors.jitter_s, stamps_s.shape)
    forces = np.interp(stamps_s, time_s, force) + rng.normal(0, errors.force_n, stamps_s.shape)
    areas = np.interp(stamps_s - late_s, time_s, area) * (1 + rng.normal(0, errors.area_share, stamps_s.shape))
    seen = (stamps_s <= time_s[-1]) & (forces >= window_n[0]) & (forces <= window_n[1]) & (areas > 0)
    return np.where(seen, forces, np.nan), np.where(seen, areas, np.nan)


def power_rates(
    force_n: Floats, area_mm2: Floats, window_n: tuple[float, float] = (0.5, 7.0), *, by_force: bool = True
) -> Floats:
    """(D,) mean rate over the window, mm2/N, of the power law through each press: a line of ln area on ln force.

    A frame weighs its force, as in ``casr.spread`` (which also draws areas far off towards the line), or all frames
    weigh alike. force_n, area_mm2 : (D, T) as of `frames_of`. NaN with fewer than two frames.
    """
    seen = np.isfinite(force_n)
    x, y = np.log(np.where(seen, force_n, 1.0)), np.log(np.where(seen, area_mm2, 1.0))
    weights = np.where(seen, force_n if by_force else 1.0, 0.0)
    with np.errstate(invalid="ignore", divide="ignore"):
        weights = weights / weights.sum(axis=1, keepdims=True)
        middle_x, middle_y = (weights * x).sum(axis=1), (weights * y).sum(axis=1)
        off = x - middle_x[:, None]
        power = (weights * off * y).sum(axis=1) / (weights * off**2).sum(axis=1)
        level = np.exp(middle_y - power * middle_x)
        low, high = window_n
        return np.asarray(level * (high**power - low**power) / (high - low))
