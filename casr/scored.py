"""What is asked of a press and what comes out: the settings of a score, and the score."""

from __future__ import annotations

import platform
from dataclasses import dataclass, field, fields, is_dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from casr import __version__
from casr.contact_area import RULES, InitialArea
from casr.errors import SettingError
from casr.flow.estimate import FlowSettings
from casr.flow.region import Region
from casr.frames import CameraLag, ForceZero
from casr.pins import Pins
from casr.spread import AREA_LAWS, RATE_RULES, WINDOW_N, SpreadRate

MOST_LAG_S = 10.0


@dataclass(frozen=True, kw_only=True)
class ScoreSettings:
    """How a press is scored.

    Parameters
    ----------
    flow : how growth is measured.
    area_rule : one of ``casr.contact_area.RULES``, for the initial area.
    area_law, rate_rule : of ``casr.spread``: eq. (1) and eq. (2). rate_window_n : forces between which rule ``power``
        takes the mean rate, N, wherever scoring starts and stops.
    threshold_px : a pin that moved further than this from rest is in contact.
    force_start_n : force of first contact, N. force_stop_n : force to stop at, N, None for the largest.
    region : the contact in the first scored frame, instead of the one found from the pins; all of it is measured, not
        only its core.
    tare : the force at rest before contact is taken off all forces.
    camera_lag_s : the frames were taken so long before their times, s. correct_lag : as long as the pins tell.
    """

    flow: FlowSettings = field(default_factory=FlowSettings)
    area_rule: str = "edge"
    area_law: str = "ode"
    rate_rule: str = "power"
    rate_window_n: tuple[float, float] = WINDOW_N
    threshold_px: float = 2.0
    force_start_n: float = 0.5
    force_stop_n: float | None = None
    region: Region | None = None
    tare: bool = True
    camera_lag_s: float = 0.0
    correct_lag: bool = False

    def __post_init__(self) -> None:
        choices = {"area_rule": RULES, "area_law": AREA_LAWS, "rate_rule": RATE_RULES}
        for key, known in choices.items():
            value = getattr(self, key)
            if value not in known:
                raise SettingError(key, wanted=f"one of {', '.join(known)}", found=repr(value), do="Choose one.")
        if not 0 < self.threshold_px < np.inf:
            raise SettingError(
                "threshold_px", wanted="a distance above 0 px", found=repr(self.threshold_px), do="The paper uses 2."
            )
        if not abs(self.camera_lag_s) <= MOST_LAG_S:
            raise SettingError(
                "camera_lag_s",
                wanted=f"seconds from {-MOST_LAG_S:g} to {MOST_LAG_S:g}",
                found=repr(self.camera_lag_s),
                do="0.05 is 50 ms; correct other clocks in the force log.",
            )
        if self.correct_lag and self.camera_lag_s:
            raise SettingError(
                "correct_lag, camera_lag_s",
                wanted="one of the two",
                found=f"both, and a lag of {self.camera_lag_s:g} s",
                do="Give the lag, or have it found.",
            )


@dataclass(frozen=True, kw_only=True, eq=False)
class Score:
    """One scored press of T frames.

    Parameters
    ----------
    name : of the sequence. settings : as asked.
    rest_frame : index of the static frame. frames : (T,) indices scored, the first is first contact.
    force_n : (T,) N, None without a force log.
    divergence, log_growth : (T-1,) of the step that leads to each frame but the first, 1/frame.
    initial : A_c0 and the pins it comes from. rest : pins of the rest frame. contact_px : (N, 2) the same pins in the
        first scored frame, NaN where lost.
    area : (T,) contact area in ``area_unit``, ``mm2`` or without a camera ``px2``.
    rate : contact area spread rate; None without a force log.
    regions : T outlines (K, 2) of the region that growth was measured in, px.
    notes : what a reader of these numbers should know.
    force_zero : what the force sensor reads at rest; None where that is not determined or there is no force log.
    camera_lag : how late the frames are against the force; None without times in the force log.
    doubts : reasons to look at this press before its numbers count; empty where there are none.
    """

    name: str
    settings: ScoreSettings
    rest_frame: int
    frames: NDArray[np.intp]
    force_n: NDArray[np.float64] | None
    divergence: NDArray[np.float64]
    log_growth: NDArray[np.float64]
    initial: InitialArea
    rest: Pins
    contact_px: NDArray[np.float64]
    area: NDArray[np.float64]
    area_unit: str
    rate: SpreadRate | None
    regions: tuple[NDArray[np.float64], ...]
    notes: tuple[str, ...]
    force_zero: ForceZero | None = None
    camera_lag: CameraLag | None = None
    doubts: tuple[str, ...] = ()

    def to_dict(self) -> dict[str, Any]:
        """JSON-ready, with what it takes to get the same numbers again. NaN of a lost pin becomes None."""
        plain = {each.name: _plain(getattr(self, each.name)) for each in fields(self)}
        provenance = {
            "casr": __version__,
            "numpy": np.__version__,
            "opencv": cv2.__version__,
            "python": platform.python_version(),
        }
        return plain | {"provenance": provenance}


def _plain(value: Any) -> Any:
    """Dataclasses as mappings, arrays and tuples as lists, numbers that are not finite as None."""
    if is_dataclass(value):
        return {each.name: _plain(getattr(value, each.name)) for each in fields(value)}
    if isinstance(value, np.ndarray | np.generic):
        return _plain(value.tolist())
    if isinstance(value, tuple | list):
        return [_plain(each) for each in value]
    return None if isinstance(value, float) and not np.isfinite(value) else value
