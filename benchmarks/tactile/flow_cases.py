"""Cases of the areas ``flow``, ``pins`` and ``growth``: motion between two frames, and growth over many."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import cache, partial
from typing import Any

import numpy as np

from benchmarks.bench.case import Case, Size, Way, Work
from benchmarks.experts import contacts
from benchmarks.tactile.flow_pairs import FlowPair, contact_pair
from benchmarks.tactile.flow_scores import (
    LOG_GROWTH,
    LOOKS,
    RADII_PITCHES,
    GrowingContact,
    core_of,
    error_of_pair,
    growing_contact,
    growth_error_percent,
    percent_error,
    root_mean_square,
    worst,
)
from benchmarks.tactile.methods import Method, dense, on_pins
from casr.flow.estimate import ENGINES, FlowSettings, FlowTracker
from casr.pins import PinTracker
from emg2vsa.worlds.tactile import TACTIP_127

MOTIONS_PX = (0.25, 1.0, 3.0, 6.0)
SEEDS, SLOW_SEEDS = 12, 3
WHAT_PAIR = "pair of frames of 127 pins, 300 x 300 px, noise 2 grey levels"
TRUTH = "the divergence that the frames were drawn with, over seeds"


def pin_cases(size: Size) -> Iterator[Case]:
    """The affine motion of the contact's pins."""
    yield from _pair_cases(size, "motion of the contact's pins", on_pins())


def dense_cases(size: Size) -> Iterator[Case]:
    """Flow at every pixel."""
    yield from _pair_cases(size, "dense flow", dense())


def _pair_cases(size: Size, what: str, methods: Sequence[Method]) -> Iterator[Case]:
    """Of each motion two cases, whose errors are the rms and the bias over seeds."""
    seeds = size.pick(2, SEEDS)
    chosen = [method for method in methods if method.installed and not (size is Size.SMOKE and method.slow)]
    for motion in size.pick((1.0,), MOTIONS_PX):
        for kind, of_errors in (("rms", root_mean_square), ("bias", _mean)):
            ways = tuple(_way(method, motion, seeds, of_errors) for method in chosen)
            yield Case(
                f"{what}, rim motion {motion:g} px: {kind} of the divergence", 1, WHAT_PAIR, ways, None,
                f"{kind}, % of the divergence", TRUTH,
            )  # fmt: skip


def _way(method: Method, motion_px: float, seeds: int, of_errors: Callable[[Any], float]) -> Way:
    pair = _pair(motion_px, 0)
    made: list[Callable[[], Any]] = []

    def run() -> Any:
        if not made:  # what belongs to the frame before is done once
            made.append(method.prepare(pair.first, pair.second, core_of(pair)))
        return made[0]()

    used = min(SLOW_SEEDS, seeds) if method.slow else seeds
    work: Work = "as used" if method.note else "equal"
    return Way(
        method.library, method.name, run, work, method.note, lambda _: of_errors(_errors(method, motion_px, used))
    )


@cache
def _pair(motion_px: float, seed: int) -> FlowPair:
    return contact_pair(motion_px, seed)


@cache
def _errors(method: Method, motion_px: float, seeds: int) -> np.ndarray:
    """Of the core's divergence, percent (seeds,)."""
    return np.array([error_of_pair(method, _pair(motion_px, seed)) for seed in range(seeds)])


def _mean(errors: np.ndarray) -> float:
    return float(np.mean(errors))


def growth_cases(size: Size) -> Iterator[Case]:
    """Growth of a contact of some pitches' radius, followed over ten steps by every engine."""
    seeds = size.pick(1, 4)
    for radius in size.pick((2.0,), RADII_PITCHES):
        for look in size.pick(("clean",), tuple(LOOKS)):
            ways = tuple(
                Way(
                    "casr", engine, partial(_followed, engine, radius, look), "equal",
                    error=partial(_worst_growth, engine, radius, look, seeds),
                )
                for engine in ENGINES
            )  # fmt: skip
            name, note = "expert: PyrLK on pins, affine", "told the pins and their first places"
            error = partial(_worst_of_patches, radius, look, seeds)
            ways += (Way("OpenCV", name, partial(_by_patches, radius, look), "equal", note, error),)
            yield Case(
                f"growth of a {look} contact of {radius:g} pitches", 10, "steps from frame to frame", ways, None,
                "worst, % of the growth", "ln of the ratio of areas that the frames were drawn with",
            )  # fmt: skip


def _followed(engine: str, radius: float, look: str) -> float:
    contact = _contact(radius, look, 1, 0)
    tracker = FlowTracker(FlowSettings(engine=engine))
    tracker.start(contact.frames[0], contact.region)
    return sum(tracker.step(frame).log_growth for frame in contact.frames[1:])


def _by_patches(radius: float, look: str, power: int = 1, seed: int = 0) -> float:
    return contacts.growth(_contact(radius, look, power, seed).frames, _pins_inside(radius, look, power, seed))


@cache
def _pins_inside(radius: float, look: str, power: int, seed: int) -> np.ndarray:
    """Places (n, 2) of the contact's pins in its first frame, told to the expert."""
    contact = _contact(radius, look, power, seed)
    places = PinTracker().start(contact.frames[0]).centroids_px
    return np.asarray(places[contact.region.contains(places)])


def _worst_of_patches(radius: float, look: str, seeds: int, _: float) -> float:
    every = [_by_patches(radius, look, power, seed) for power in (1, 2) for seed in range(seeds)]
    return worst([float(percent_error(one, LOG_GROWTH)) for one in every])


@cache
def _contact(radius: float, look: str, power: int, seed: int) -> GrowingContact:
    return growing_contact(radius * TACTIP_127.pitch_px, seed, power=power, look=LOOKS[look])


@cache
def _growth_errors(engine: str, radius: float, look: str, seeds: int) -> list[float]:
    return [
        growth_error_percent(engine, _contact(radius, look, power, seed)) for power in (1, 2) for seed in range(seeds)
    ]


def _worst_growth(engine: str, radius: float, look: str, seeds: int, _: float) -> float:
    return worst(_growth_errors(engine, radius, look, seeds))
