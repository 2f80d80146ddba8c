"""One simulated press, rendered once, through every engine; the rules' areas and rates from the pieces of its score."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from itertools import product

import cv2
import numpy as np

from benchmarks.tactile.array_frames import ArrayFrames
from benchmarks.tactile.metrics import percent_error
from casr.contact_area import RULES, initial_area
from casr.errors import CasrError
from casr.flow.estimate import ENGINES, FlowSettings
from casr.frames import FrameSequence
from casr.scoring import Score, ScoreSettings, score
from casr.spread import AREA_LAWS, RATE_RULES, contact_areas, spread_rate
from emg2vsa.worlds.tactile import PressSettings, SimulatedPress, simulate_press

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
