"""Flow engine ``pin-affine``: the pins of the contact region, tracked, and the affine map that fits them best."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from casr.errors import PinsError, SettingError
from casr.flow.region import Affine, Points, Region
from casr.flow.step import FlowSettings, FlowStep
from casr.images import Grey
from casr.median import median
from casr.pins import PinTracker
from casr.pins.lattice import NEIGHBOURS, at_border, nearest_pins, pin_pitch_px

FEWEST_PINS = 3
ROUND_ENOUGH_TO_FIT = 1e-3  # smallest spread of the pins across a line over the spread along it
OUTLIER_SIGMA = 6.0  # of the residuals' robust scatter
OUTLIER_PITCHES = 1 / 3  # a mistaken pin is off by about one pitch, a bulging skin departs from affine by far less
LEAST_OUTLIER_PX = 0.5
MEDIAN_OF_RAYLEIGH = 1.1774  # median length of a 2-D residual of unit scatter per axis


def fit_affine(before_px: NDArray[np.float64], after_px: NDArray[np.float64]) -> Affine:
    """Least-squares affine motion of pins (N, 2) -> (N, 2), row by row; NaN rows are left out.

    A pin off by more than a third of the pitch and by six times the scatter of the others was mistaken for another one:
    the worst is left out and the fit repeated until none stands out; a note says so.

    PinsError : fewer than three pins, or all close to one line.
    """
    before, after = np.asarray(before_px, float), np.asarray(after_px, float)
    rows = seen = np.flatnonzero(np.isfinite(before + after).all(axis=1))
    fit, residual = _fit(before[rows], after[rows])
    while (worst := _mistaken(before[rows], residual)) is not None:
        rows = np.delete(rows, worst)
        fit, residual = _fit(before[rows], after[rows])
    return replace(fit, notes=("pins mistaken for others are left out",)) if len(rows) < len(seen) else fit


def _fit(before: NDArray[np.float64], after: NDArray[np.float64]) -> tuple[Affine, NDArray[np.float64]]:
    """The fit and the length (N,) of each pin's residual."""
    if len(before) < FEWEST_PINS:
        raise _too_few(f"{len(before)}")
    move = after - before
    centre, offset = before.mean(axis=0), move.mean(axis=0)
    arm, rest = before - centre, move - offset
    (xx, xy), (_, yy) = (arm.T @ arm).tolist()
    # eigenvalues and inverse of two by two numbers written out: the library's cost more than the whole fit
    half, apart = (xx + yy) / 2, math.hypot((xx - yy) / 2, xy)
    if not half - apart > ROUND_ENOUGH_TO_FIT**2 * (half + apart):
        raise _too_few(f"{len(before)} on one line")
    inverse = np.array([[yy, -xy], [-xy, xx]]) / (xx * yy - xy * xy)
    matrix = (inverse @ (arm.T @ rest)).T
    error = rest - arm @ matrix.T
    squared = np.einsum("ij,ij->i", error, error)
    return Affine(matrix, offset, centre, len(before)), np.sqrt(squared)


def _mistaken(before: NDArray[np.float64], residual: NDArray[np.float64]) -> int | None:
    """The pin that was taken for another one, if there is any."""
    worst = int(residual.argmax())
    scatter = float(np.partition(residual, len(residual) // 2)[len(residual) // 2]) / MEDIAN_OF_RAYLEIGH
    # the pitch costs more than the fit, so it comes last
    if residual[worst] <= max(OUTLIER_SIGMA * scatter, LEAST_OUTLIER_PX) or len(residual) <= FEWEST_PINS + 1:
        return None
    return worst if residual[worst] > OUTLIER_PITCHES * pin_pitch_px(before) else None


def _too_few(found: str) -> PinsError:
    return PinsError(
        "affine fit", wanted=f"{FEWEST_PINS} or more pins that are not on one line", found=found,
        do="Widen the region, or see why pins are lost: are the frames one press, in order?",
    )  # fmt: skip


PIN_SCATTER_PX = 0.4
EDGE_SD_PX = 1.0


class _BulgingRegion:
    """A region of the first frame and where its pins take it.

    A skin that bulges everywhere grows least at the border of a region, where its area is decided; an affine fit to the
    pins inside then overstates the area's growth (0.301 for 0.290 on a real flat press). So the displacement may also
    have a part depth^2 (x - centre), depth being 0 at the centre and 1 on the border. Its one parameter is shrunk as if
    it were known to be within 1 px at the border, and pins to scatter by 0.4 px (0.3 measured on that press): a few
    pins at one distance from the centre say nothing of it, and the motion stays affine.

    region : in the first frame. pins_px : (N, 2) the pins it is followed by, there.
    """

    def __init__(self, region: Region, pins_px: Points) -> None:
        self._region, self._pins_px = region, pins_px
        self._pin_bulge, self._border_bulge = _bulge(region, pins_px), _bulge(region, region.polygon_px)
        self._doubt = region.area_px2 / np.pi * (PIN_SCATTER_PX / EDGE_SD_PX) ** 2
        self._seen: NDArray[np.intp] = np.empty(0, np.intp)

    def at(self, pins_px: Points) -> tuple[Region, Affine]:
        """The region when its pins are at (N, 2), NaN where one is lost; and the affine fit.

        PinsError : fewer than three pins, or all close to one line.
        """
        affine = fit_affine(self._pins_px, pins_px)
        error = pins_px - self._pins_px - affine.displacement_px(self._pins_px)
        # the fit leaves out mistaken pins, those furthest off; a lost pin's NaN sorts last
        seen = np.sort(np.argsort((error**2).sum(axis=1), kind="stable")[: affine.n])
        self._use(seen)
        strength = float((self._beyond * error[seen]).sum()) / self._weight
        border_px = self._region.polygon_px
        return Region(border_px + affine.displacement_px(border_px) + strength * self._border_beyond), affine

    def _use(self, seen: NDArray[np.intp]) -> None:
        """What the bulge has beyond its own affine part, for these pins."""
        if np.array_equal(seen, self._seen):
            return
        self._seen, pins_px = seen, self._pins_px[seen]
        affine_part = fit_affine(pins_px, pins_px + self._pin_bulge[seen])
        self._beyond = self._pin_bulge[seen] - affine_part.displacement_px(pins_px)
        self._border_beyond = self._border_bulge - affine_part.displacement_px(self._region.polygon_px)
        self._weight = float((self._beyond**2).sum()) + self._doubt


def _bulge(region: Region, points_px: Points) -> Points:
    return np.asarray(region.depth(points_px)[:, None] ** 2 * (points_px - region.centre_px))


SPARE_PINS = 7  # with three, the loss of one would leave too few at once
ROUND_ENOUGH = 0.1  # spread of the pins across a line over the spread along it


class PinEngine:
    """Measures by the pins that lie in the core of the region at first contact.

    The region is a piece of skin, so its pins stay the same. The map is fitted from the first frame to the present one
    and steps are differences: errors of single centroids do not add up over frames, and a pin that is lost for a while
    leaves no trace. While too few of them are seen, the pins just outside help: the region then moves as they all do
    from the frame before to this one.

    A frame that cannot be measured is an error and changes nothing: the next one is measured from the last good one.
    """

    def __init__(self, settings: FlowSettings) -> None:
        self._settings = settings
        self._tracker = PinTracker(settings.pins)

    def start(self, image: Grey, region: Region, pins_px: Points | None) -> None:
        """Take the first frame, or its pins (N, 2) px, and choose those of the region."""
        start_px = pins_px if pins_px is not None else self._tracker.start(image).centroids_px
        self._outwards = _outwards(region, start_px)
        self._ids, self.start_notes = _pins_of(region, start_px, self._outwards, self._settings.core_fraction)
        self._pitch_px = pin_pitch_px(start_px)
        beside = nearest_pins(start_px[self._outwards], NEIGHBOURS)[1]
        self._border = self._outwards[at_border(start_px[self._outwards], beside)]
        self._region, self._last_px = region, start_px
        self._skin = _BulgingRegion(region, start_px[self._ids])

    def step(self, image: Grey, pins_px: Points | None) -> FlowStep:
        """Growth by the region's pins (N, 2) px in this frame. PinsError : too few pins are seen in and beside the
        region."""
        now_px = self._tracker.step(image) if pins_px is None else pins_px
        seen = np.isfinite(now_px[:, 0])
        if _span_a_plane(now_px[self._ids[seen[self._ids]]]):
            region, affine = self._skin.at(now_px[self._ids])
            helped: tuple[str, ...] = ()
        else:
            affine = self._helped_out(now_px, seen & np.isfinite(self._last_px[:, 0]))
            region = self._region.advanced(affine)
            helped = (f"fewer than {FEWEST_PINS} of the region's pins are seen: those just outside it help",)
        divergence, log_growth = self._region.growth_to(region)
        own_px = now_px[self._ids]
        jump = self._jump(now_px - self._last_px)
        knock = self._tracker.notes if pins_px is None else ()
        notes = (*affine.notes, *self._lost(own_px), *helped, *jump, *knock)
        self._region, self._last_px = region, now_px
        return FlowStep(divergence, log_growth, region, affine.n, notes)

    def _helped_out(self, now_px: Points, usable: NDArray[np.bool_]) -> Affine:
        """The map from the frame before by the innermost pins that fix one, no more than there are in and beside it."""
        near = self._outwards[: len(self._ids) + SPARE_PINS]
        helpers = near[usable[near]]
        for n in range(FEWEST_PINS, len(helpers) + 1):
            if _span_a_plane(now_px[helpers[:n]]):
                return fit_affine(self._last_px[helpers[:n]], now_px[helpers[:n]])
        own = int(np.isfinite(now_px[self._ids, 0]).sum())
        raise PinsError(
            "region", wanted=f"{FEWEST_PINS} or more pins in or beside it that are not on one line",
            found=f"{len(helpers)}, of the {len(self._ids)} inside at first {own}",
            do="Widen the region, or see why pins are lost: are the frames one press, in order?",
        )  # fmt: skip

    def _lost(self, now_px: Points) -> tuple[str, ...]:
        lost = int(np.isnan(now_px[:, 0]).sum())
        share = "most" if 2 * lost > len(now_px) else "some"
        return (f"{share} of the region's {len(now_px)} pins are not seen",) if lost else ()

    def _jump(self, move_px: Points) -> tuple[str, ...]:
        """Beyond half a pitch, pins are told apart only by the guess that neighbours move alike.

        Not so if the border of the array jumps with them: it fits in one place only.
        """
        border = move_px[self._border][np.isfinite(move_px[self._border, 0])]
        moved_px = np.hypot(*(move_px[self._ids] - (median(border) if len(border) else 0.0)).T)
        moved_px = moved_px[np.isfinite(moved_px)]
        typical_px = float(median(moved_px)) if moved_px.size else 0.0
        if typical_px <= self._pitch_px / 2:
            return ()
        return ("pins jump beyond half their pitch: are these frames one press, in order?",)


def need_pins_inside(region: Region, pins_px: Points) -> None:
    """Check a region that somebody gives against pins (N, 2), px.

    SettingError : it holds too few of them to measure its growth by.
    """
    inside = int(region.contains(pins_px[np.isfinite(pins_px[:, 0])]).sum())
    if inside < FEWEST_PINS:
        raise SettingError(
            "region", wanted=f"{FEWEST_PINS} or more pins inside it",
            found=f"{inside} around ({region.centre_px[0]:.0f}, {region.centre_px[1]:.0f})",
            do=f"Give a larger region; the pins are {pin_pitch_px(pins_px):.3g} px apart.",
        )  # fmt: skip


def _outwards(region: Region, pins_px: Points) -> NDArray[np.intp]:
    """Rows of the pins that are seen, from the middle of the region outwards."""
    depth = region.depth(pins_px)
    return np.argsort(depth, kind="stable")[: int(np.isfinite(depth).sum())]  # NaN of lost pins sorts last


def _pins_of(
    region: Region, pins_px: Points, outwards: NDArray[np.intp], core_fraction: float
) -> tuple[NDArray[np.intp], tuple[str, ...]]:
    """Rows of the pins in the core; where those are few, of the region; where they fix no map, the next ones too."""
    depth = region.depth(pins_px[outwards])
    n_core, n_inside = int(np.sum(depth <= core_fraction)), int(np.sum(depth <= 1))
    n = max(n_core, min(n_inside, SPARE_PINS), FEWEST_PINS)
    while n < len(outwards) and not _span_a_plane(pins_px[outwards[:n]]):
        n += 1
    n_outside = int(np.sum(depth[:n] > 1))
    if n - n_outside < 1:
        raise PinsError("region", wanted="pins inside it", found="none", do="Check the region, or use a dense engine.")
    note = f"{n_outside} of {n} pins lie outside the region, which holds too few: its growth is underestimated"
    return np.sort(outwards[:n]), (note,) if n_outside else ()


def _span_a_plane(points_px: Points) -> bool:
    if len(points_px) < FEWEST_PINS:
        return False
    spread = np.linalg.svd(points_px - points_px.mean(axis=0), compute_uv=False)
    return bool(spread[1] > ROUND_ENOUGH * spread[0])
