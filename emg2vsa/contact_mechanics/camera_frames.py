"""A simulated press as a camera sees it: few frames, each a little late, with forces and areas a little off."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from emg2vsa.arrays import Floats
from emg2vsa.contact_mechanics.press_path import PressPaths


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
    first_s: float,
    errors: FrameErrors,
    rng: np.random.Generator,
    *,
    rate_hz: float = 20.0,
    window_n: tuple[float, float] = (0.5, 7.0),
) -> tuple[Floats, Floats]:
    """(T,) forces and (T,) areas of the frames whose force lies in the window; the first is ``first_s`` after contact.

    A frame shows the contact as it was before its time stamp by the delay.
    """
    known = np.isfinite(paths.force_n[:, press])
    time_s, force, area = paths.time_s[known], paths.force_n[known, press], paths.area_mm2[known, press]
    stamps_s = np.arange(first_s, time_s[-1], 1 / rate_hz)
    late_s = errors.latency_s + rng.normal(0, errors.latency_sd_s) + rng.normal(0, errors.jitter_s, stamps_s.size)
    forces = np.interp(stamps_s, time_s, force) + rng.normal(0, errors.force_n, stamps_s.size)
    areas = np.interp(stamps_s - late_s, time_s, area) * (1 + rng.normal(0, errors.area_share, stamps_s.size))
    seen = (forces >= window_n[0]) & (forces <= window_n[1]) & (areas > 0)
    return forces[seen], areas[seen]
