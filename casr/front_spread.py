"""Spread of the contact front over force: its rate with a total interval, and the stretch of skin beside it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from casr.camera import Camera, undistorted
from casr.contact_area.front import ContactFront
from casr.contact_area.motion import check_area
from casr.errors import AreaError, FramesError
from casr.flow.region import Region
from casr.spread import WINDOW_N, SpreadRate, TotalInterval, spread_rate, spread_rates, total_interval
from casr.spread.intervals import CONFIDENCE, normal_quantile

Array = NDArray[np.float64]

MOST_MISFIT = 0.15
"""Share of the motion left over beyond which the pins tell of some other thing than the contact of a dome."""
FEWEST_FRAMES = 4
SKIN_SD = 0.05
"SD of the logarithm of the growth of skin: by flow it is 2 to 20 % too small in finite elements."
BEYOND_SD = 0.06
"""Relative standard error of a mean rate for each e-fold of force that the window reaches beyond the last frame:
presses that end at 5, 4, 3, 2 and 1.3 N are 2, 4, 5, 8 and 11 % off on eight domes of finite elements (SD)."""
APART_SD = 0.005
"Relative standard error of one area against another of the same press: narrow windows feel it most."
FORCE_ZERO_SD_N = 0.02
"Standard error of a resting level that nobody measured."
_LEAST_WEIGHT = 1e-3
LEFT_OUT = ("another mounting of sensor or specimen",)


@dataclass(frozen=True, eq=False)
class FrontSpread:
    """A front that is determined.

    rate : None without forces. interval : total, of the rate. first, first_n : index among the scored frames of the
    first whose area is determined, and its force. skin_over_front : ratio of the growth of the first contact's skin to
    that of the area over the frames that are determined, and its 95 % interval.
    """

    rate: SpreadRate | None
    interval: TotalInterval | None
    first: int
    first_n: float
    skin_over_front: tuple[float, float, float]


def front_doubt(front: ContactFront, pins_px: Sequence[Array], camera: Camera | None, some: slice = slice(None)) -> str:
    """Why no area can be told from this front; empty where it can.

    pins_px : T places (N, 2) of the pins. some : of the frames that are held against the pin array.
    """
    if front.misfit > MOST_MISFIT:
        return (
            f"the pins do not move as on a dome that is pressed: {front.misfit:.0%} of their motion is left over by "
            "every contact that is known"
        )
    if int(front.determined.sum()) < FEWEST_FRAMES:
        return (
            f"the contact is too small for the pitch of the pins: its radius is {front.pitches.max():.2g} pitches and "
            f"{int(front.pins_inside.max())} pins lie inside at most"
        )
    for row in np.arange(len(front.area))[some][front.determined[some]]:
        area_px2 = Region(undistorted(front.edge_px[row], camera)).area_px2
        try:
            check_area(area_px2, undistorted(pins_px[row], camera), "front", camera)
        except AreaError as error:
            return f"the edge lies beyond the pins ({error})"
    return ""


def front_spread(
    front: ContactFront,
    skin_log_growth: Array,
    force_n: Array | None,
    force_zero_sd_n: float | None,
    *,
    rule: str = "power",
    area_unit: str = "mm2",
    window_n: tuple[float, float] = WINDOW_N,
) -> FrontSpread:
    """Rate over the frames of T that are determined (paper, eq. 2, of the front's area).

    skin_log_growth : (T-1,) of the steps.
    force_n : (T,) N, or None. rule, area_unit, window_n (N) : of ``spread_rate``.
    force_zero_sd_n : standard error of the resting level, N; None where none was taken off.
    """
    used = front.determined
    first = int(np.argmax(used))
    ratio = _skin_over_front(front, skin_log_growth, first)
    if force_n is None:
        return FrontSpread(None, None, first, np.nan, ratio)
    force = force_n[used]
    rate = spread_rate(front.area[used], force, rule=rule, area_unit=area_unit, window_n=window_n)
    parts = {
        "scatter": (rate.scatter_high - rate.scatter_low) / 2 / normal_quantile(CONFIDENCE) / rate.value
        if rate.scatter_low is not None and rate.scatter_high is not None
        else np.nan
    }
    heavy = np.flatnonzero(front.spread_weight > _LEAST_WEIGHT)
    names = ("pin length", "depth", "beyond the tables")
    areas = [*front.candidates[heavy], *(front.area * np.exp(front.parts[name]) for name in names)]
    apart = spread_rates(np.array(areas)[:, used], force, rule=rule, window_n=window_n) / rate.value - 1
    weight = front.spread_weight[heavy] / front.spread_weight[heavy].sum()
    parts["dome"] = float(np.hypot(np.sqrt(weight @ apart[: heavy.size] ** 2), front.model_sd))
    parts["misfit"] = float(front.parts["misfit"].max())
    parts |= dict(zip(names, np.abs(apart[heavy.size :]).tolist(), strict=True))
    parts |= _of_window(rate, force)
    zero_n = FORCE_ZERO_SD_N if force_zero_sd_n is None else force_zero_sd_n
    try:
        shifted = spread_rate(front.area[used], force + zero_n, rule=rule, window_n=window_n)
        parts["force zero"] = abs(shifted.value / rate.value - 1)
    except FramesError:
        parts["force zero"] = np.nan
    return FrontSpread(rate, total_interval(rate.value, parts, LEFT_OUT), first, float(force_n[first]), ratio)


def _of_window(rate: SpreadRate, force_n: Array) -> dict[str, float]:
    """Errors that the window of a mean rate adds: it reaches beyond the frames, or it is narrow."""
    if rate.law is None or rate.window_n is None:
        return {}
    low_n, high_n = rate.window_n
    first, last = rate.law.area(low_n), rate.law.area(high_n)
    return {
        "beyond the frames": BEYOND_SD * max(float(np.log(high_n / force_n.max())), 0.0),
        "narrow window": APART_SD * (last + first) / abs(last - first) if last != first else np.nan,
    }


def _skin_over_front(front: ContactFront, skin_log_growth: Array, first: int) -> tuple[float, float, float]:
    skin = float(skin_log_growth[first:].sum())
    grown = np.log(front.candidates[:, -1] / front.candidates[:, first])
    mean = float(np.log(front.area[-1] / front.area[first]))
    spread = float(np.sqrt(front.spread_weight @ (grown - mean) ** 2))
    lengths = front.parts["pin length"]
    error = np.sqrt(
        spread**2
        + 2 * front.model_sd**2
        + SKIN_SD**2
        + float((front.parts["pins"][[first, -1]] ** 2).sum())
        + float(lengths[-1] - lengths[first]) ** 2
        + float(front.parts["misfit"][-1]) ** 2
    )
    reach = normal_quantile(CONFIDENCE) * error
    ratio = skin - mean
    return float(np.exp(ratio)), float(np.exp(ratio - reach)), float(np.exp(ratio + reach))
