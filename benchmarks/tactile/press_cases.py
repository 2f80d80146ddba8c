"""Cases of the areas ``area`` and ``scoring``: simulated presses in memory, their first area and their rate."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache, partial

import cv2
import numpy as np

from benchmarks.bench.case import Case, Size, Way
from benchmarks.tactile.press_scores import rendered
from casr.contact_area import initial_area
from casr.flow.estimate import ENGINES, FlowSettings
from casr.frames import FrameSequence
from casr.pins import Pins
from casr.scoring import Score, ScoreSettings, score
from emg2vsa.worlds.tactile import ContactWorld, PressSettings, SimulatedPress, TimelineSettings, simulate_press

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
