"""One simulated press, rendered once, through every engine; the rules' areas and rates from the pieces of its score.

A frame source in memory, so that reading costs nothing while scoring is timed.

Cases of the areas ``area`` and ``scoring``: simulated presses in memory, their first area and their rate.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import cache, partial
from itertools import product
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.bench.case import Case, Size, Way
from benchmarks.experts import contacts
from benchmarks.tactile.flow_scores import percent_error
from casr.contact_area import RULES, initial_area
from casr.errors import CasrError, FramesError
from casr.flow.estimate import ENGINES, FlowSettings
from casr.frames import FrameSequence
from casr.images import Grey, as_grey
from casr.pins import Pins
from casr.scoring import Score, ScoreSettings, score
from casr.spread import AREA_LAWS, RATE_RULES, contact_areas, spread_rate
from emg2vsa.worlds.tactile import ContactWorld, PressSettings, SimulatedPress, TimelineSettings, simulate_press


class ArrayFrames:
    """Frames held in memory: a (T, H, W) array, or (T, H, W, 3) in BGR order, of any type `as_grey` takes.

    Raises
    ------
    FramesError : another number of dimensions.
    """

    def __init__(self, frames: NDArray[Any], *, name: str = "frames") -> None:
        frames = np.asarray(frames)
        if frames.ndim not in (3, 4):
            raise FramesError(
                name,
                wanted="frames as a (T, H, W) or (T, H, W, 3) array",
                found=f"shape {frames.shape}",
                do="Stack the frames along the first axis.",
            )
        self.name = name
        self._frames = frames

    @property
    def shape(self) -> tuple[int, int]:
        return int(self._frames.shape[1]), int(self._frames.shape[2])

    def __len__(self) -> int:
        return len(self._frames)

    def read(self, index: int) -> Grey:
        return as_grey(self._frames[index], where=f"{self.name}, frame {index}")


SPECIMENS_N_PER_MM = (1.11, 3.35, 7.63)
ANGLES_DEG = (0.0, 30.0, 45.0)
MOVED_PX = 2.0


@dataclass(frozen=True, eq=False)
class First:
    """Pins of a press at rest and at first contact, its camera's mm^2 per px^2, and the true area, mm^2."""

    rest: Pins
    contact_px: np.ndarray
    mm2_per_px2: float
    true_mm2: float


def area_cases(size: Size) -> Iterator[Case]:
    """Initial areas of presses from pins that were already found."""
    for angle in size.pick((0.0,), ANGLES_DEG):
        presses = [_first(k, angle, r) for k in SPECIMENS_N_PER_MM for r in range(size.pick(1, 6))]
        ways = [
            Way("casr", rule, partial(_areas, presses, rule), "equal")
            for rule in ("edge", "hexagon", "paper", "circle")
        ]
        ways.append(Way("OpenCV", "convexHull of moved pins", partial(_hulls, presses), "equal"))
        ways.append(Way("numpy", "expert: moments of moved pins", partial(_ellipses, presses), "equal"))
        yield Case(
            f"first area of contact at {angle:g} degrees", len(presses), "presses, pins known", tuple(ways),
            partial(_rms_percent, presses), "rms, % of the area", "the simulated contact's area",
        )  # fmt: skip


@cache
def _first(stiffness: float, angle: float, repetition: int) -> First:
    press = simulate_press(_settings(stiffness, angle, repetition))
    found = score(rendered(press), ScoreSettings(quantity="skin"))
    true_mm2 = float(press.truth.area_mm2[found.frames[0]])
    return First(found.rest, found.contact_px, press.settings.camera.mm2_per_px2, true_mm2)


def _settings(stiffness: float, angle: float, repetition: int) -> PressSettings:
    return PressSettings(
        stiffness_n_per_mm=stiffness, angle_deg=angle, repetition=repetition, world=ContactWorld(),
        timeline=TimelineSettings(loading_s=1.5),
    )  # fmt: skip


def _areas(presses: list[First], rule: str) -> np.ndarray:
    """px^2."""
    return np.array([initial_area(one.rest, one.contact_px, rule=rule).area_px2 for one in presses])


def _ellipses(presses: list[First]) -> np.ndarray:
    """px^2."""
    return np.array([contacts.first_area(one.rest.centroids_px, one.contact_px, MOVED_PX) for one in presses])


def _hulls(presses: list[First]) -> np.ndarray:
    """px^2 around the pins that moved."""
    found = []
    for one in presses:
        moved = np.hypot(*(one.contact_px - one.rest.centroids_px).T) > MOVED_PX
        points = one.contact_px[moved].astype(np.float32)
        found.append(cv2.contourArea(cv2.convexHull(points)) if len(points) > 2 else 0.0)
    return np.array(found)


def _rms_percent(presses: list[First], found_px2: np.ndarray) -> float:
    ratio = [area * one.mm2_per_px2 / one.true_mm2 for area, one in zip(found_px2, presses, strict=True)]
    return 100 * float(np.sqrt(np.mean((np.array(ratio) - 1) ** 2)))


def scoring_cases(size: Size) -> Iterator[Case]:
    """Presses in memory to their contact area spread rate; of one family by the length of a press."""
    for loading_s in size.pick((1.2,), (1.2, 2.4, 4.8)):
        press, sequence = _press(loading_s)
        asked = {"front": ScoreSettings()}
        asked |= {f"skin by {engine}": _by_skin(engine) for engine in ENGINES}
        ways = tuple(Way("casr", name, partial(score, sequence, settings), "equal") for name, settings in asked.items())
        yield Case(
            f"a press of {len(sequence)} frames", len(sequence), "frames in memory", ways,
            partial(_rate_percent, press), "size, % of dA/dF", "the rate of the simulated contact, by the power law",
            "press to spread rate",
        )  # fmt: skip


@cache
def _press(loading_s: float) -> tuple[SimulatedPress, FrameSequence]:
    press = simulate_press(PressSettings(timeline=TimelineSettings(loading_s=loading_s)))
    return press, rendered(press)


def _by_skin(engine: str) -> ScoreSettings:
    return ScoreSettings(quantity="skin", flow=FlowSettings(engine=engine))


def _rate_percent(press: SimulatedPress, found: Score) -> float:
    assert found.rate is not None, "the press has no rate"
    return 100 * abs(found.rate.value / press.truth.casr_power_mm2_per_n - 1)


TRUE_AREA = "true area"
"Stands for an area rule that knows A_c0: what is left is the error of the growth."
Chain = tuple[str, str, str, str]
"Engine, area rule, area law, rate rule."
CHAINS: list[Chain] = list(product(ENGINES, (*RULES, TRUE_AREA), AREA_LAWS, RATE_RULES))


@dataclass
class PressScores:
    """What was found on one press and what is true; numbers are NaN where an engine or rule gave an error.

    stiffness_n_mm, angle_deg, repetition : which press.
    true_casr : by rate rule, mm^2/N.
    casr : by chain, mm^2/N.
    area_error_percent : of A_c0, by area rule. growth_error_percent : of ln(A_n / A_c0), by engine.
    time_s : processor time from frames in memory to a score, by engine.
    failures : what could not be computed, and what was said.
    """

    stiffness_n_mm: float
    angle_deg: float
    repetition: int
    true_casr: dict[str, float]
    casr: dict[Chain, float] = field(default_factory=lambda: dict.fromkeys(CHAINS, float("nan")))
    area_error_percent: dict[str, float] = field(default_factory=lambda: dict.fromkeys(RULES, float("nan")))
    growth_error_percent: dict[str, float] = field(default_factory=lambda: dict.fromkeys(ENGINES, float("nan")))
    time_s: dict[str, float] = field(default_factory=lambda: dict.fromkeys(ENGINES, float("nan")))
    failures: dict[str, str] = field(default_factory=dict)


def scored(settings: PressSettings) -> PressScores:
    """Render this press and score it every way."""
    cv2.setNumThreads(1)
    press = simulate_press(settings)
    truth = press.truth
    result = PressScores(
        settings.stiffness_n_per_mm,
        settings.angle_deg,
        settings.repetition,
        {
            "power": truth.casr_power_mm2_per_n,
            "slope": truth.casr_slope_mm2_per_n,
            "paper": truth.casr_paper_mm2_per_n,
        },
    )
    sequence = rendered(press)
    for engine in ENGINES:
        start = time.process_time()
        try:
            found = score(sequence, ScoreSettings(quantity="skin", flow=FlowSettings(engine=engine)))
        except CasrError as error:
            result.failures[engine] = str(error)
            continue
        result.time_s[engine] = time.process_time() - start
        _judge(result, engine, found, press)
    return result


def rendered(press: SimulatedPress) -> FrameSequence:
    """The press with its frames in memory and its measured forces."""
    sequence = press.sequence()
    return replace(sequence, source=ArrayFrames(np.stack(list(sequence)), name=sequence.name))


def _judge(result: PressScores, engine: str, found: Score, press: SimulatedPress) -> None:
    true_mm2 = press.truth.area_mm2[found.frames]
    growth = np.log(true_mm2[-1] / true_mm2[0])
    result.growth_error_percent[engine] = float(percent_error(found.log_growth.sum(), growth))
    for rule, area_mm2 in _initial_areas(result, found, press).items():
        if rule != TRUE_AREA:
            result.area_error_percent[rule] = float(percent_error(area_mm2, true_mm2[0]))
        for law, rate, casr in _rates(result, found, area_mm2):
            result.casr[engine, rule, law, rate] = casr


def _initial_areas(result: PressScores, found: Score, press: SimulatedPress) -> dict[str, float]:
    camera = press.settings.camera
    areas = {TRUE_AREA: float(press.truth.area_mm2[found.frames[0]])}
    for rule in RULES:
        try:
            initial = initial_area(found.rest, found.contact_px, camera=camera, rule=rule)
            areas[rule] = initial.area_px2 * camera.mm2_per_px2
        except CasrError as error:
            result.failures[f"area by {rule}"] = str(error)
    return areas


def _rates(result: PressScores, found: Score, area_mm2: float) -> Iterator[tuple[str, str, float]]:
    force_n = np.array(found.force_n, dtype=np.float64)
    steps = {"ode": found.log_growth, "paper": found.divergence}
    for law, rate in product(AREA_LAWS, RATE_RULES):
        try:
            areas = contact_areas(area_mm2, steps[law], force_n, law=law)
            yield law, rate, spread_rate(areas, force_n, rule=rate).value
        except CasrError as error:
            result.failures[f"law {law} with rate {rate}"] = str(error)
