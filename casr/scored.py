"""What is asked of a press and what comes out: the settings of a score, and the score."""

from __future__ import annotations

import platform
from dataclasses import dataclass, field, fields, is_dataclass
from functools import cached_property
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from casr import __version__
from casr.contact_area import RULES, FirstContact, InitialArea
from casr.contact_area.front import ContactFront
from casr.errors import SettingError
from casr.flow.estimate import FlowSettings
from casr.flow.region import Region
from casr.frames import CameraLag, ForceZero
from casr.front_spread import FrontSpread
from casr.pins import Pins
from casr.spread import AREA_LAWS, RATE_RULES, WINDOW_N, SpreadRate, TotalInterval, total_interval
from casr.spread.intervals import CONFIDENCE, normal_quantile

MOST_LAG_S = 10.0


QUANTITIES = ("front", "skin")
WHOLE_IMAGE = "image"
SKIN_AREA_SD = 0.25
"""Relative standard error of A_c0 by an edge rule or hexagons on sensors that nobody fitted it to: -23 to +52 % (finite
elements), +16 to +44 % (another simulator)."""
SKIN_LEFT_OUT = ("that a contact grows by taking in new skin, which this quantity does not see",)


@dataclass(frozen=True, eq=False)
class SkinSpread:
    """The skin of the first contact. area : (T,). rate : None without a force log. interval : total, of the rate."""

    area: NDArray[np.float64]
    rate: SpreadRate | None
    interval: TotalInterval | None


@dataclass(frozen=True, eq=False)
class Spread:
    """What one quantity says of a press.

    quantity : one of ``QUANTITIES``. area : (T,), NaN where it is not determined. rate : None without a force log or
    with a doubt. interval : total, of the rate. doubt : why nothing can be told; empty where it can.
    """

    quantity: str
    area: NDArray[np.float64]
    rate: SpreadRate | None
    interval: TotalInterval | None
    doubt: str

    @property
    def first(self) -> int | None:
        """The first frame whose area is determined; None where there is none."""
        known = np.flatnonzero(np.isfinite(self.area))
        return int(known[0]) if known.size else None


def skin_interval(rate: SpreadRate, area_sd: float | None) -> TotalInterval | None:
    """Total interval of a rate of skin whose initial area has a relative standard error ``area_sd`` by its own fit."""
    if rate.scatter_low is None or rate.scatter_high is None or not rate.value > 0:
        return None
    scatter = (rate.scatter_high - rate.scatter_low) / 2 / normal_quantile(CONFIDENCE) / rate.value
    return total_interval(
        rate.value, {"scatter": scatter, "initial area": float(np.hypot(area_sd or 0.0, SKIN_AREA_SD))}, SKIN_LEFT_OUT
    )


NO_SCALE = (
    "areas are in px², not mm²: no camera.toml in the folder of the press or the folder above it, and none given "
    "(casr calibrate makes one)"
)
"Note on a press without a camera."


@dataclass(frozen=True, kw_only=True)
class ScoreSettings:
    """How a press is scored.

    Parameters
    ----------
    quantity : which area is the result: ``front``, the contact whose edge is followed in every frame, or ``skin``, the
        first contact's skin as the flow stretches it (the paper's). Both are always there.
    domes : folder of a lab's own tables of domes, beside those that come with casr.
    specimen_height_mm : thickness of the specimen, for tables of this height or between two; None: of any height. Those
        that come with casr are of 25 mm.
    flow : how growth of skin is measured.
    area_rule : one of ``casr.contact_area.RULES``, for the initial area.
    area_law, rate_rule : of ``casr.spread``: eq. (1) and eq. (2). rate_window_n : forces between which rule ``power``
        takes the mean rate, N; None: from ``force_start_n`` to ``force_stop_n``, or 7 N where that is None.
    threshold_px : a pin that moved further than this from rest is in contact.
    force_start_n : force of first contact, N. force_stop_n : force to stop at, N, None for the largest.
    region : the contact in the first scored frame, instead of the one found from the pins; all of it is measured, not
        only its core. ``image``, for dense engines: growth of skin is the mean divergence of the whole image.
    tare : the force at rest before contact is taken off all forces.
    camera_lag_s : the frames were taken so long before their times, s; None: as long as the pins tell, where they do so
        to 10 ms, or tell more than half a frame and twice the error (``CameraLag.sure``). correct_lag : as long as the
        pins tell, however well.
    """

    quantity: str = "front"
    domes: str | None = None
    specimen_height_mm: float | None = None
    flow: FlowSettings = field(default_factory=FlowSettings)
    area_rule: str = "edge"
    area_law: str = "ode"
    rate_rule: str = "power"
    rate_window_n: tuple[float, float] | None = None
    threshold_px: float = 2.0
    force_start_n: float = 0.5
    force_stop_n: float | None = None
    region: Region | str | None = None
    tare: bool = True
    camera_lag_s: float | None = None
    correct_lag: bool = False

    @property
    def window_n(self) -> tuple[float, float]:
        """The forces, N, between which rule ``power`` takes the mean rate."""
        return self.rate_window_n or (self.force_start_n, self.force_stop_n or WINDOW_N[1])

    def __post_init__(self) -> None:
        choices = {"quantity": QUANTITIES, "area_rule": RULES, "area_law": AREA_LAWS, "rate_rule": RATE_RULES}
        for key, known in choices.items():
            value = getattr(self, key)
            if value not in known:
                raise SettingError(
                    key, wanted=f"one of {', '.join(known)}", found=repr(value), do="Choose one of these."
                )
        if isinstance(self.region, str) and (self.region != WHOLE_IMAGE or self.flow.engine == "pin-affine"):
            raise SettingError(
                "region", wanted=f"a region, or {WHOLE_IMAGE!r} with a dense engine, horn-schunck or dis",
                found=f"{self.region!r} with {self.flow.engine}",
                do="Leave it out, give x,y,radius, or choose an engine (--engine dis).",
            )  # fmt: skip
        if not 0 < self.threshold_px < np.inf:
            raise SettingError(
                "threshold_px", wanted="a distance above 0 px", found=repr(self.threshold_px), do="The paper uses 2."
            )
        if self.specimen_height_mm is not None and not 0 < self.specimen_height_mm < np.inf:
            raise SettingError(
                "specimen_height_mm", wanted="a height above 0 mm", found=repr(self.specimen_height_mm),
                do="Measure the specimen, or leave it out.",
            )  # fmt: skip
        if self.camera_lag_s is not None and not abs(self.camera_lag_s) <= MOST_LAG_S:
            raise SettingError(
                "camera_lag_s", wanted=f"seconds from {-MOST_LAG_S:g} to {MOST_LAG_S:g}", found=repr(self.camera_lag_s),
                do="0.05 is 50 ms; correct other clocks in the force log.",
            )  # fmt: skip
        if self.correct_lag and self.camera_lag_s is not None:
            raise SettingError(
                "correct_lag, camera_lag_s", wanted="one of the two",
                found=f"both, and a lag of {self.camera_lag_s:g} s", do="Give the lag, or have it found.",
            )  # fmt: skip


@dataclass(frozen=True, kw_only=True, eq=False)
class Score:
    """One scored press of T frames.

    Parameters
    ----------
    name : of the sequence. settings : as asked.
    rest_frame : index of the static frame. frames : (T,) indices scored, the first is first contact.
    force_n : (T,) N, None without a force log.
    divergence, log_growth : (T-1,) of the step that leads to each frame but the first, 1/frame.
    initial : A_c0 and the pins it comes from. rest : N pins of the rest frame. pins_px : (T, N, 2) the same pins in
        the frames scored, NaN where lost.
    area_unit : ``mm2``, or without a camera ``px2``.
    skin : what the first contact's skin says: A_c0 and its growth by the flow (the paper's).
    front : what the edge says that is followed in every frame. front_doubt : why no area can be told from it; empty
        where it can. front_spread : its rate; None where there is doubt.
    regions : T outlines (K, 2) of the region that growth was measured in, px.
    notes : what a reader of these numbers should know.
    force_zero : what the force sensor reads at rest; None where that is not determined or there is no force log.
    camera_lag : how late the frames are against the force; None without times in the force log.
    doubts : reasons to look at this press before its numbers count; empty where there are none.
    travel_mm_per_n : mean travel of the indenter for each newton, as over 0.5 to 7 N; None without travel.
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
    pins_px: NDArray[np.float64]
    area_unit: str
    skin: SkinSpread
    front: ContactFront
    front_doubt: str
    front_spread: FrontSpread | None
    regions: tuple[NDArray[np.float64], ...]
    notes: tuple[str, ...]
    force_zero: ForceZero | None = None
    camera_lag: CameraLag | None = None
    doubts: tuple[str, ...] = ()
    travel_mm_per_n: float | None = None

    def __repr__(self) -> str:
        """The answer; the arrays are too long to read."""
        rate, interval = self.rate, self.interval
        told = "no spread rate" if rate is None else f"CASR {rate.value:.4g} {rate.unit}"
        told += f" [{interval.low:.4g}, {interval.high:.4g}]" if interval else ""
        doubts = f", {len(self.doubts)} doubts" if self.doubts else ""
        return f"Score({self.name!r}: {told} by {self.settings.quantity}, {len(self.frames)} frames{doubts})"

    @property
    def contact_px(self) -> NDArray[np.float64]:
        """(N, 2) the pins in the first scored frame."""
        return np.asarray(self.pins_px[0])

    def by(self, quantity: str) -> Spread:
        """What one of ``QUANTITIES`` says."""
        if quantity == "skin":
            return Spread("skin", self.skin.area, self.skin.rate, self.skin.interval, "")
        area = np.where(self.front.determined & (self.front_doubt == ""), self.front.area, np.nan)
        rate = self.front_spread.rate if self.front_spread else None
        interval = self.front_spread.interval if self.front_spread else None
        return Spread("front", area, rate, interval, self.front_doubt)

    @property
    def chosen(self) -> Spread:
        """The spread by the quantity of the settings."""
        return self.by(self.settings.quantity)

    @property
    def other(self) -> Spread:
        """The spread by the quantity that was not asked for."""
        return self.by("front" if self.settings.quantity == "skin" else "skin")

    @property
    def area(self) -> NDArray[np.float64]:
        """(T,) contact area by the quantity of the settings, in ``area_unit``; NaN where a front is not determined."""
        return self.chosen.area

    @property
    def rate(self) -> SpreadRate | None:
        """Spread rate by the quantity of the settings; None without a force log, or where a front is not determined."""
        return self.chosen.rate

    @property
    def interval(self) -> TotalInterval | None:
        """Total 95 % interval of ``rate``."""
        return self.chosen.interval

    @property
    def first(self) -> int | None:
        """Among the scored frames the first whose ``area`` is known; None where there is none."""
        return self.chosen.first

    def to_dict(self) -> dict[str, Any]:
        """JSON-ready, with what it takes to get the same numbers again. NaN of a lost pin becomes None.

        Trajectories of pins are left out: they are a table (``casr.press_tables``).
        """
        chosen = ("contact_px", "area", "rate", "interval")
        plain = {name: _plain(getattr(self, name)) for name in (*_kept(self), *chosen)}
        provenance = {
            "casr": __version__,
            "numpy": np.__version__,
            "opencv": cv2.__version__,
            "python": platform.python_version(),
        }
        return plain | {"provenance": provenance}


@dataclass(frozen=True, kw_only=True, eq=False)
class SkinScore:
    """The skin of the first contact alone, in T frames of a press: what ``Score`` holds of it, under the same names."""

    rest_frame: int
    frames: NDArray[np.intp]
    force_n: NDArray[np.float64]
    divergence: NDArray[np.float64]
    initial: InitialArea
    rest: Pins
    contact_px: NDArray[np.float64]
    area_unit: str
    skin: SkinSpread
    regions: tuple[NDArray[np.float64], ...]
    notes: tuple[str, ...]
    force_zero: ForceZero | None = None

    @cached_property
    def first_contact(self) -> FirstContact:
        """What areas by other rules follow from."""
        return FirstContact.of(self.rest.centroids_px, self.contact_px)


_OF_PINS = ("pins_px", "inside")
"Names of what is as large as frames times pins."


def _kept(value: Any) -> list[str]:
    return [each.name for each in fields(value) if each.name not in _OF_PINS]


def _plain(value: Any) -> Any:
    """Dataclasses as mappings, arrays and tuples as lists, numbers that are not finite as None."""
    if is_dataclass(value):
        return {name: _plain(getattr(value, name)) for name in _kept(value)}
    if isinstance(value, np.ndarray | np.generic):
        return _plain(value.tolist())
    if isinstance(value, dict):
        return {key: _plain(each) for key, each in value.items()}
    if isinstance(value, tuple | list):
        return [_plain(each) for each in value]
    return None if isinstance(value, float) and not np.isfinite(value) else value
