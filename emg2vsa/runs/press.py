"""One press by every vision algorithm, from one pass over its frames."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from casr.camera import Camera
from casr.contact_area import initial_area
from casr.errors import CasrError
from casr.frames import FrameSequence
from casr.score import score
from casr.scored import Score, ScoreSettings
from casr.spread import contact_areas, spread_rate
from emg2vsa.arrays import Floats
from emg2vsa.runs.indentation import indentation_slope
from emg2vsa.runs.product import ALGORITHMS, ContactPicture, PressCurve


@dataclass(frozen=True, eq=False)
class Press:
    """A press as it was recorded.

    frames : None where they cannot be read, and ``problem`` says why. force_n, depth_mm : (K,) of the loading phase
    from the rig's log, empty without one.
    """

    repetition: int
    frames: FrameSequence | None
    problem: str
    force_n: Floats
    depth_mm: Floats


@dataclass(frozen=True, eq=False)
class ScoredPress:
    """Numbers of one press; ``a_c0`` and ``casr`` by algorithm, NaN where an algorithm finds nothing."""

    a_c0: dict[str, float]
    casr: dict[str, float]
    area_unit: str
    indent_n_per_mm: float
    curve: PressCurve
    scored: Score
    notes: tuple[str, ...]


def score_press(press: Press, settings: ScoreSettings) -> ScoredPress:
    """Score a press whose frames are there. CasrError where it cannot be scored.

    Growth is measured once: with the consistent area law an algorithm's areas differ by the factor of its A_c0 alone.
    """
    assert press.frames is not None
    scored = score(press.frames, _within_reach(settings, press.frames))
    if scored.rate is None or scored.force_n is None:
        raise CasrError(
            press.frames.name,
            wanted="a force for every frame",
            found="no force log",
            do="Put the force log beside the frames as force.csv: a spread rate is an area per newton.",
        )
    a_c0 = {name: _first_area(scored, press.frames.camera, name, settings) for name in ALGORITHMS}
    casr = {name: scored.rate.value * area / scored.area[0] for name, area in a_c0.items()}
    casr["paper"] = _to_the_letter(scored, a_c0["paper"])
    slope, indent_n, indent_mm = indentation_slope(press.force_n, press.depth_mm, settings.force_start_n)
    return ScoredPress(
        a_c0=a_c0,
        casr=casr,
        area_unit=scored.area_unit,
        indent_n_per_mm=slope,
        curve=PressCurve(scored.force_n, scored.area, indent_n, indent_mm),
        scored=scored,
        notes=scored.notes,
    )


def _within_reach(settings: ScoreSettings, frames: FrameSequence) -> ScoreSettings:
    """Loading ends at the largest force where no frame was taken at F_max: the press turns back between two."""
    reached = frames.force_n is not None and np.nanmax(frames.force_n, initial=0.0) >= (settings.force_stop_n or 0.0)
    return settings if reached else replace(settings, force_stop_n=None)


def picture_of(press: Press, scored: ScoredPress) -> ContactPicture:
    """First contact of a scored press."""
    assert press.frames is not None
    found = scored.scored
    return ContactPicture(
        image=np.asarray(press.frames[int(found.frames[0])]).astype(np.uint8),
        pins_px=found.rest.centroids_px,
        contact_px=found.contact_px[found.initial.selected],
        area_mm2=float(found.area[0]),
    )


def _first_area(scored: Score, camera: Camera | None, rule: str, settings: ScoreSettings) -> float:
    if rule == settings.area_rule:
        return float(scored.area[0])
    try:
        found = initial_area(
            scored.rest, scored.contact_px, camera=camera, rule=rule, threshold_px=settings.threshold_px
        )
    except CasrError:
        return np.nan
    return found.area_px2 if found.area_mm2 is None else found.area_mm2


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
