"""One simulated press of a world, rendered, scored and held against its truth.

Worlds that presses are simulated in, each with the library of domes that may explain them.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cache
from math import nan
from pathlib import Path
from unittest.mock import patch

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.tactile.flow_scores import percent_error
from benchmarks.tactile.press_scores import rendered
from casr.camera import Camera
from casr.dome.library import FAMILY, SHIPPED, Library, shipped, with_between
from casr.dome.library import worlds as all_domes
from casr.dome.view import INNER_RADIUS_MM
from casr.doubts import Stretch, stretch_of
from casr.errors import CasrError, SettingError
from casr.front_spread import FrontSpread
from casr.scored import ScoreSettings, SkinSpread
from casr.scoring import Score, score
from casr.spread import WINDOW_N
from emg2vsa.worlds.tactile import ContactWorld, PressSettings, SimulatedPress, TabulatedWorld, World, simulate_press

Array = NDArray[np.float64]

FULL_TABLES = Path(os.environ.get("EMG2VSA_TEST_DATA", Path(__file__).parents[3] / "shared" / "data")) / "contact_fem"
STICK_FORCES_N = (0.1, 0.43, 1.0, 2.0)
FRONT_FORCE_N = 7.0
"Of the last press: no skin is caught before it."
FRICTIONS = ("stick", "frictionless")


@dataclass(frozen=True)
class BenchWorld:
    """A world. library : that its presses are scored with. absent : why it cannot be simulated here, or empty."""

    world: World | None
    library: Library
    absent: str = ""


GROUPS = {
    "tabulated": ("tabulated", "tabulated-frictionless"),
    "full": ("full", "full-frictionless"),
    "domes": tuple(f"dome-{dome}-{friction}" for dome in FAMILY for friction in FRICTIONS),
    "stick": (*(f"stick-{force:g}" for force in STICK_FORCES_N), "front"),
}
GROUPS["all"] = tuple(name for group in GROUPS.values() for name in group)


def named(asked: Sequence[str]) -> tuple[str, ...]:
    """Names of worlds, from names of worlds and of groups. SettingError for another name."""
    found: dict[str, None] = {}
    for name in asked:
        names = GROUPS.get(name, (name,) if name in GROUPS["all"] else ())
        if not names:
            raise SettingError(
                "--world", wanted=f"{', '.join(GROUPS)} or one of {', '.join(GROUPS['all'])}", found=repr(name),
                do="Check the spelling.",
            )  # fmt: skip
        found |= dict.fromkeys(names)
    return tuple(found)


@cache
def world_named(name: str) -> BenchWorld:
    """One world of ``GROUPS``."""
    kind, _, rest = name.partition("-")
    if kind == "dome":
        dome, _, friction = rest.partition("-")
        return BenchWorld(TabulatedWorld(friction=friction, dome=dome, tables=SHIPPED), without(dome))
    if kind == "stick":
        return BenchWorld(ContactWorld(stick_force_n=float(rest)), all_domes())
    if kind == "front":
        return BenchWorld(ContactWorld(stick_force_n=FRONT_FORCE_N), all_domes())
    friction = rest or "stick"
    if kind == "tabulated":
        return BenchWorld(TabulatedWorld(friction=friction), all_domes())
    if not FULL_TABLES.is_dir():
        return BenchWorld(None, all_domes(), f"no {FULL_TABLES.name} (EMG2VSA_TEST_DATA names the folder above it)")
    return BenchWorld(TabulatedWorld(friction=friction, tables=str(FULL_TABLES)), all_domes())


def without(dome: str) -> Library:
    """The shipped library as it would be without one dome."""
    library = shipped()
    kept = library.dome != dome
    arrays = {field.name: getattr(library, field.name) for field in fields(Library)}
    grids = {name: arrays.pop(name) for name in ("radius_mm", "arc_mm")}
    return with_between(Library(**grids, **{name: np.asarray(array)[kept] for name, array in arrays.items()}))


FORCES_N = (0.5, 1.0, 2.0, 4.0)
LEAST_PITCHES = 2.0
"Of the true radius, from which on an error of the area counts."


@dataclass(frozen=True)
class Found:
    """A number and its total 95 % interval; NaN where there is none."""

    value: float = nan
    low: float = nan
    high: float = nan

    def holds(self, truth: float) -> bool:
        return self.low <= truth <= self.high


@dataclass(frozen=True)
class WorldScore:
    """What was found on one press.

    world : name. stiffness_n_mm, angle_deg, repetition : which press. refused : why there is no front; empty else.
    area_error_percent : by force, N, where the true radius is large enough. log_area_error, area_sd : of each frame
    that is determined, and its relative standard error.
    true_casr : mm^2/N. front, skin : found. stretch : of skin over front.
    model, misfit : of the front. notes : of the score. doubts : reasons to check it.
    """

    world: str
    stiffness_n_mm: float
    angle_deg: float
    repetition: int
    true_casr: float
    refused: str = ""
    area_error_percent: dict[float, float] = field(default_factory=dict)
    log_area_error: Array = field(default_factory=lambda: np.empty(0))
    area_sd: Array = field(default_factory=lambda: np.empty(0))
    front: Found = Found()
    skin: Found = Found()
    stretch: Stretch | None = None
    model: str = ""
    misfit: float = nan
    notes: tuple[str, ...] = ()
    doubts: tuple[str, ...] = ()


def world_scored(
    name: str, settings: PressSettings, camera: Camera | None = None, least_pitches: float = LEAST_PITCHES,
    stop_n: float | None = None,
) -> WorldScore:  # fmt: skip
    """Render this press in the world of that name, and score its frames as ``casr score`` does.

    camera : what camera.toml says, if it is not what the frames were taken with. least_pitches : of the true radius,
    from which on an error of the area counts. stop_n : at which the frames that are scored end, and CASR.
    """
    cv2.setNumThreads(1)
    bench = world_named(name)
    assert bench.world is not None
    press = simulate_press(replace(settings, world=bench.world))
    truth = press.truth.casr_power_mm2_per_n if stop_n is None else _true_rate(press, stop_n)
    result = WorldScore(name, settings.stiffness_n_per_mm, settings.angle_deg, settings.repetition, truth)
    try:
        with patch("casr.press_scorer.worlds_for", return_value=bench.library):  # a dome may be left out
            found = score(
                replace(rendered(press), camera=camera or settings.camera), ScoreSettings(force_stop_n=stop_n)
            )
    except CasrError as error:
        return replace(result, refused=str(error))
    spread = found.front_spread
    sure = found.front.determined
    return replace(
        result,
        refused=found.front_doubt or ("" if spread and spread.rate else "no rate"),
        area_error_percent=_area_errors(found, press, least_pitches) if not found.front_doubt else {},
        log_area_error=np.log(found.front.area / press.truth.area_mm2[found.frames])[sure],
        area_sd=found.front.relative_sd[sure],
        front=_found(spread) if spread else Found(),
        skin=_found(found.skin),
        stretch=stretch_of(found),
        model=found.front.model,
        misfit=found.front.misfit,
        notes=found.notes,
        doubts=found.doubts,
    )


def _true_rate(press: SimulatedPress, stop_n: float) -> float:
    force_n, window_n = press.truth.force_n, (WINDOW_N[0], stop_n)
    rising = slice(0, int(force_n.argmax()) + 1)
    first, last = np.interp(window_n, force_n[rising], press.truth.area_mm2[rising])
    return float((last - first) / (stop_n - WINDOW_N[0]))


def _found(spread: FrontSpread | SkinSpread) -> Found:
    if spread.rate is None:
        return Found()
    interval = spread.interval
    return Found(spread.rate.value, interval.low, interval.high) if interval else Found(spread.rate.value)


def _area_errors(found: Score, press: SimulatedPress, least_pitches: float) -> dict[float, float]:
    truth, s = press.truth, press.settings
    tip_mm = INNER_RADIUS_MM - (s.camera.sensor.pin_length_mm or 0.0)
    pitch_mm = s.skin.pitch_px * s.camera.mm_per_px[0] * INNER_RADIUS_MM / tip_mm
    errors = {}
    for force_n in FORCES_N:
        row = int(np.argmin(np.abs(truth.force_n[found.frames] - force_n)))
        true_mm2 = float(truth.area_mm2[found.frames[row]])
        if np.sqrt(true_mm2 / np.pi) >= least_pitches * pitch_mm:
            errors[force_n] = float(percent_error(found.front.area[row], true_mm2))
    return errors
