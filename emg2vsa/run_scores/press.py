"""One press by every vision algorithm; and by how fast its force rises (kinesthesia)."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from casr.errors import CasrError
from casr.frames import FrameSequence, travel_per_newton
from casr.scored import SkinScore
from emg2vsa.arrays import Floats
from emg2vsa.run_scores.domes import NO_DOMES, Domes
from emg2vsa.run_scores.measured import Measured, Numbers
from emg2vsa.run_scores.product import ALGORITHMS, PICTURED_N, ContactPicture, PressCurve, PressPins
from emg2vsa.settings import RunSettings


@dataclass(frozen=True, eq=False)
class Press:
    """A press as it was recorded.

    frames : None where they cannot be read, and ``problem`` says why. force_n, depth_mm : (K,) from the rig's log while
    the probe goes in, empty without one; the loading phase begins after ``n_before`` of them. area_unit : of its areas,
    whether or not it can be scored. mounting : number of the folder of its run that it comes from, from 1. peak_n :
    largest force, N, with what it went beyond the force at which it turned back; NaN without the table of presses.
    pressed_at : see ``RunScores``.
    """

    repetition: int
    frames: FrameSequence | None
    problem: str
    force_n: Floats
    depth_mm: Floats
    area_unit: str = "mm2"
    mounting: int = 1
    peak_n: float = math.nan
    n_before: int = 0
    pressed_at: float = math.nan


@dataclass(frozen=True, eq=False)
class ScoredPress:
    """Numbers of one press, by algorithm; NaN where an algorithm finds nothing (see ``RunScores``).

    missing : algorithm to why it has no rate. over_array : see ``measured.Numbers``. by_paper : the skin by the recipe
    "paper", where that finds some. pins : see ``RunScores``.
    """

    a_c0: dict[str, float]
    start_area: dict[str, float]
    casr: dict[str, float]
    area_unit: str
    indent_n_per_mm: float
    curve: PressCurve
    picture: ContactPicture | None
    missing: dict[str, str]
    over_array: dict[str, float]
    notes: tuple[str, ...]
    by_paper: SkinScore | None
    pins: PressPins | None


def score_press(press: Press, settings: RunSettings, domes: Domes = NO_DOMES) -> ScoredPress:
    """Score a press whose frames are there. CasrError where the algorithm of the settings cannot."""
    assert press.frames is not None
    if press.frames.force_n is None:
        raise CasrError(
            press.frames.name, wanted="a force for every frame", found="no force log",
            do="Put the force log beside the frames as force.csv: a spread rate is an area per newton.",
        )  # fmt: skip
    measured = Measured(press.frames, settings, domes)
    by, skin = {name: measured.numbers(name) for name in ALGORITHMS}, measured.skin
    own = by[settings.algorithm]
    # the rig's log is of the same sensor
    zero_n = skin.force_zero.level_n if skin.force_zero else 0.0
    known, stretch = np.isfinite(own.area), measured.stretch
    curve = PressCurve(
        skin.force_n[: known.size][known], own.area[known], float(skin.force_n[0]), press.force_n - zero_n,
        press.depth_mm,
    )  # fmt: skip
    if stretch is not None:
        curve = replace(
            curve, stretch_force_n=stretch.force_n, stretch_log_ratio=stretch.log_ratio, stretch_log_sd=stretch.log_sd
        )
    after = slice(press.n_before, None)
    travel_mm_per_n = travel_per_newton(press.force_n[after] - zero_n, press.depth_mm[after], settings.force_n[0])
    return ScoredPress(
        a_c0={name: found.a_c0 for name, found in by.items()},
        start_area={name: found.start_area for name, found in by.items()},
        casr={name: found.casr for name, found in by.items()},
        area_unit=skin.area_unit,
        indent_n_per_mm=1 / travel_mm_per_n,
        curve=curve,
        picture=_picture(press.frames, skin, own),
        missing={name: found.missing for name, found in by.items() if found.missing},
        over_array={name: found.over_array for name, found in by.items()},
        notes=measured.notes,
        by_paper=measured.by_paper,
        pins=measured.pins,
    )


def _picture(frames: FrameSequence, skin: SkinScore, own: Numbers) -> ContactPicture | None:
    """The frame nearest to ``PICTURED_N`` with the outline that the algorithm finds; None where it finds none."""
    known = np.flatnonzero(np.isfinite(own.area))
    if not known.size:
        return None
    i = int(known[np.argmin(np.abs(skin.force_n[known] - PICTURED_N))])
    return ContactPicture(
        image=np.asarray(frames[int(skin.frames[i])]).astype(np.uint8),
        force_n=float(skin.force_n[i]),
        outline_px=np.asarray(own.outlines_px[i], dtype=np.float64),
        area_mm2=float(own.area[i]),
    )
