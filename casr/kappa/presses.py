"""A press as kappa is estimated from it: pins in loaded frames, forces, and what is known of the specimen."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from casr.errors import FramesError, PinsError, SettingError
from casr.scored import Score

Array = NDArray[np.float64]

FEWEST_FRAMES, MOST_SEEN = 5, 0.9
FEWEST_PINS = 30
"Seen in every frame that is taken."
MOST_MM_PER_N = 50.0
FORCE_ZERO_SD_N, LEAST_FORCE_ZERO_SD_N = 0.02, 0.005


@dataclass(frozen=True, kw_only=True, eq=False)
class KappaPress:
    """One press of T loaded frames, force rising.

    rest_px : (N, 2) pins at rest as the camera sees them. pins_px : (T, N, 2) in contact; NaN where lost.
    force_n : (T,) N, or None.
    specimen : name; presses of one specimen have one stiffness. mounting : name; what was mounted once.
    stiffness_n_per_mm : known kappa of the specimen, inf of a rigid plate, or None; stiffness_sd : its relative
        standard error.
    travel_mm_per_n : mean travel of the indenter for each newton, over the same forces in all presses, or None.
    rest_frames : that ``rest_px`` is the mean of. force_zero_sd_n : standard error of the force's zero, N.
    """

    rest_px: Array
    pins_px: Array
    force_n: Array | None = None
    specimen: str = ""
    mounting: str = ""
    stiffness_n_per_mm: float | None = None
    stiffness_sd: float = 0.0
    rest_frames: int = 1
    force_zero_sd_n: float = FORCE_ZERO_SD_N
    travel_mm_per_n: float | None = None
    name: str = ""

    def __post_init__(self) -> None:
        n_frames, n_pins = self.pins_px.shape[:2]
        where = f"press {self.name or self.specimen}".rstrip()
        if self.pins_px.shape[1:] != self.rest_px.shape or self.rest_px.shape[1:] != (2,):
            raise PinsError(
                f"{where}, pins_px", wanted=f"the {n_pins} pins of rest_px, (T, N, 2)",
                found=f"{self.rest_px.shape} at rest and {self.pins_px.shape} in contact", do="Follow the same pins.",
            )  # fmt: skip
        if n_frames < FEWEST_FRAMES:
            raise FramesError(
                f"{where}, pins_px", wanted=f"{FEWEST_FRAMES} loaded frames or more", found=str(n_frames),
                do="Press more slowly, or take more frames a second.",
            )  # fmt: skip
        force_n = self.force_n
        if force_n is not None and (force_n.shape != (n_frames,) or not np.isfinite(force_n).all()):
            raise FramesError(
                f"{where}, force_n", wanted=f"a finite number for each of {n_frames} frames",
                found=f"shape {force_n.shape}", do="Leave it out where it is not known.",
            )  # fmt: skip
        known = self.stiffness_n_per_mm
        if known is not None and not known > 0:
            raise SettingError(
                f"{where}, stiffness_n_per_mm", wanted="a stiffness above 0 N/mm, or None", found=f"{known:g}",
                do="Measure it with a plate or a punch.",
            )  # fmt: skip

        travel = self.travel_mm_per_n
        if travel is not None and not 0 < travel < MOST_MM_PER_N:
            raise SettingError(
                f"{where}, travel_mm", wanted=f"travel in mm, of more than 0 and less than {MOST_MM_PER_N:g} mm/N",
                found=f"{travel:.3g} mm/N", do="Give the travel of the indenter in mm, growing towards the sensor.",
            )  # fmt: skip

    @classmethod
    def of_score(cls, score: Score, **stated: Any) -> KappaPress:
        """The loaded frames of a scored press. stated : specimen, mounting, stiffness and the like."""
        zero = score.force_zero
        zero_sd_n = FORCE_ZERO_SD_N if zero is None else max(zero.sd_n, LEAST_FORCE_ZERO_SD_N)
        return cls(
            rest_px=score.rest.centroids_px, pins_px=score.pins_px, force_n=score.force_n, force_zero_sd_n=zero_sd_n,
            travel_mm_per_n=score.travel_mm_per_n, **stated,
        )  # fmt: skip

    def seen(self) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Frames (F,) in which most pins are seen, and pins (K,) that are seen in all of them.

        PinsError : too few of either.
        """
        seen = np.isfinite(self.pins_px[..., 0])
        count = seen.sum(axis=1)
        frames = np.flatnonzero(count >= MOST_SEEN * np.median(count))
        pins = np.flatnonzero(seen[frames].all(axis=0))
        if pins.size < FEWEST_PINS or frames.size < FEWEST_FRAMES:
            raise PinsError(
                f"press {self.name or self.specimen}, pins_px",
                wanted=f"{FEWEST_PINS} pins that are seen in all of {FEWEST_FRAMES} frames",
                found=f"{pins.size} pins in {frames.size} frames", do="Look at the frames: light, focus, glare.",
            )  # fmt: skip
        return frames, pins
