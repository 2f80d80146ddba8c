"""One press by every vision algorithm, from one pass over its frames; and by how fast its force rises (kinesthesia)."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from casr.camera import Camera
from casr.contact_area import initial_area
from casr.errors import CasrError, NoContactError
from casr.frames import FrameSequence
from casr.press_forces import press_forces
from casr.score import score
from casr.scored import Score, ScoreSettings
from casr.spread import contact_areas, spread_rate
from emg2vsa.arrays import Floats
from emg2vsa.runs.product import ALGORITHMS, PICTURED_N, ContactPicture, PressCurve

OF_SKIN = tuple(name for name in ALGORITHMS if name != "front")
_REACH = 0.8
"""At 16 N/s and 20 frames a second the last frame of a press lies up to 0.8 N below its peak."""
_LEAST_ROWS = 5


@dataclass(frozen=True, eq=False)
class Press:
    """A press as it was recorded.

    frames : None where they cannot be read, and ``problem`` says why. force_n, depth_mm : (K,) of the loading phase
    from the rig's log, empty without one. area_unit : of its areas, whether or not it can be scored. mounting : number
    of the folder of its run that it comes from, from 1.
    """

    repetition: int
    frames: FrameSequence | None
    problem: str
    force_n: Floats
    depth_mm: Floats
    area_unit: str = "mm2"
    mounting: int = 1


@dataclass(frozen=True, eq=False)
class ScoredPress:
    """Numbers of one press, by algorithm; NaN where an algorithm finds nothing (see ``RunScores``)."""

    pins_selected: int
    a_c0: dict[str, float]
    start_area: dict[str, float]
    casr: dict[str, float]
    area_unit: str
    indent_n_per_mm: float
    curve: PressCurve
    scored: Score
    notes: tuple[str, ...]


def score_press(press: Press, settings: ScoreSettings) -> ScoredPress:
    """Score a press whose frames are there. CasrError where it cannot be scored.

    Growth of skin is measured once: with the consistent area law the areas of all algorithms but ``front`` differ by
    the factor of their A_c0 alone.
    """
    assert press.frames is not None
    scored = score(press.frames, _within_reach(settings, press.frames))
    if settings.quantity == "skin" and scored.initial.rule != settings.area_rule:
        raise CasrError(
            press.frames.name,
            wanted=f"an initial area by rule {settings.area_rule!r}",
            found=" ".join(scored.initial.notes),
            do="Look at the first frames (casr score --page); if they are as they should be, set another algorithm.",
        )
    if scored.skin.rate is None or scored.force_n is None:
        raise CasrError(
            press.frames.name,
            wanted="a force for every frame",
            found="no force log",
            do="Put the force log beside the frames as force.csv: a spread rate is an area per newton.",
        )
    if scored.rate is None:
        raise CasrError(
            press.frames.name,
            wanted="a contact front that can be followed",
            found=scored.front_doubt,
            do="Look at the frames (casr score --page), or set another algorithm under [runs].",
        )
    a_c0 = {name: _first_area(scored, press.frames.camera, name, settings) for name in OF_SKIN}
    casr = {name: scored.skin.rate.value * area / scored.skin.area[0] for name, area in a_c0.items()}
    casr["paper"] = _to_the_letter(scored, a_c0["paper"])
    assert scored.skin.rate.law is not None
    # the rig's log is of the same sensor
    zero_n = scored.force_zero.level_n if scored.force_zero and settings.tare else 0.0
    growth = scored.skin.rate.law.area(settings.force_start_n) / scored.skin.area[0]
    start_area = {name: area * growth for name, area in a_c0.items()} | {"paper": a_c0["paper"]}
    a_c0["front"], start_area["front"], casr["front"] = _by_front(scored, settings.force_start_n)
    known = np.isfinite(scored.area)
    return ScoredPress(
        pins_selected=_pins_selected(scored, press.frames.camera, settings.threshold_px),
        a_c0=a_c0,
        start_area=start_area,
        casr=casr,
        area_unit=scored.area_unit,
        indent_n_per_mm=indentation_slope(press.force_n - zero_n, press.depth_mm, settings.force_start_n),
        curve=PressCurve(
            scored.force_n[known], scored.area[known], float(scored.force_n[0]), press.force_n - zero_n, press.depth_mm
        ),
        scored=scored,
        notes=(*(f"check {press.frames.name}: {doubt}" for doubt in scored.doubts), *scored.notes),
    )


def _within_reach(settings: ScoreSettings, frames: FrameSequence) -> ScoreSettings:
    """Loading ends at the largest force where no frame was taken at F_max: the press turns back between two.

    CasrError where that is far below: a law through the first newtons says little of the others.
    """
    stop_n = settings.force_stop_n
    if frames.force_n is None or stop_n is None:
        return settings
    peak_n = float(np.nanmax(press_forces(frames, settings).force_n, initial=0.0))
    if peak_n < _REACH * stop_n:
        raise CasrError(
            frames.name,
            wanted=f"a press that reaches {_REACH * stop_n:.3g} N, {_REACH:.0%} of the force to score to",
            found=f"{peak_n:.3g} N at most",
            do="Press again, or lower force_n under [runs].",
        )
    return settings if peak_n >= stop_n else replace(settings, force_stop_n=None)


def picture_of(press: Press, scored: ScoredPress, algorithm: str) -> ContactPicture | None:
    """The frame nearest to ``PICTURED_N`` with the outline that ``algorithm`` finds; None where it finds none."""
    assert press.frames is not None
    found = scored.scored
    area, outlines = found.area, tuple(found.front.edge_px)
    if algorithm != "front":
        area, outlines = found.skin.area * (scored.a_c0[algorithm] / found.skin.area[0]), found.regions
    known = np.flatnonzero(np.isfinite(area))
    if not known.size or found.force_n is None:
        return None
    i = int(known[np.argmin(np.abs(found.force_n[known] - PICTURED_N))])
    return ContactPicture(
        image=np.asarray(press.frames[int(found.frames[i])]).astype(np.uint8),
        force_n=float(found.force_n[i]),
        outline_px=np.asarray(outlines[i], dtype=np.float64),
        area_mm2=float(area[i]),
    )


def _by_front(scored: Score, start_n: float) -> tuple[float, float, float]:
    """Area in the first frame and where loading begins, on the front's power law, and its rate; NaN without one."""
    rate = scored.front_spread.rate if scored.front_spread else None
    if rate is None or rate.law is None or scored.force_n is None:
        return np.nan, np.nan, np.nan
    return rate.law.area(float(scored.force_n[0])), rate.law.area(start_n), rate.value


def _first_area(scored: Score, camera: Camera | None, rule: str, settings: ScoreSettings) -> float:
    if rule == scored.initial.rule:
        return float(scored.skin.area[0])
    try:
        found = initial_area(
            scored.rest, scored.contact_px, camera=camera, rule=rule, threshold_px=settings.threshold_px
        )
    except CasrError:
        return np.nan
    if found.rule != rule:
        return np.nan
    return found.area_px2 if found.area_mm2 is None else found.area_mm2


def _pins_selected(scored: Score, camera: Camera | None, threshold_px: float) -> int:
    """n of Algorithm 1: pins whose centroid, in whole pixels, moved more than the threshold; -1 where it fails."""
    try:
        found = initial_area(scored.rest, scored.contact_px, camera=camera, rule="paper", threshold_px=threshold_px)
    except NoContactError:
        return 0
    except CasrError:
        return -1
    return int(found.selected.size)


def _to_the_letter(scored: Score, a_c0: float) -> float:
    """Equations (1) and (2) as printed."""
    if not np.isfinite(a_c0):
        return np.nan
    try:
        areas = contact_areas(a_c0, scored.divergence, scored.force_n, law="paper")
        assert scored.force_n is not None
        return spread_rate(areas, scored.force_n, rule="paper", area_unit=scored.area_unit).value
    except CasrError:
        return np.nan


def indentation_slope(force_n: Floats, depth_mm: Floats, from_n: float) -> float:
    """Slope of force over travel of the probe, N/mm, from ``from_n`` on; force_n, depth_mm : (K,).

    Travel is regressed on force, and the slope inverted: the error is in the encoder's coarse steps (0.09 degrees), and
    what enters is the mean compliance of sensor and specimen in series over the same forces for every press. NaN where
    the loading phase is too short or the probe does not go in.
    """
    known = np.isfinite(force_n) & np.isfinite(depth_mm)
    force, depth = force_n[known], depth_mm[known]
    first = int(np.argmax(force >= from_n)) if np.any(force >= from_n) else force.size
    force, depth = force[first:], depth[first:]
    if force.size < _LEAST_ROWS or np.ptp(force) == 0:
        return np.nan
    centred = force - force.mean()
    mm_per_n = float(centred @ depth / (centred @ centred))
    return 1 / mm_per_n if mm_per_n > 0 else np.nan
