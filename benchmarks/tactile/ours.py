"""This package's own ways from two frames to a motion, in the form of the comparison."""

from __future__ import annotations

from itertools import cycle

from benchmarks.tactile.method import Image, Method
from benchmarks.tactile.timing import Run
from casr.flow.horn_schunck import HornSchunck, HornSchunckSettings
from casr.flow.pin_engine import fit_affine
from casr.flow.region import Affine, Region
from casr.pins import PinTracker, detect_pins, match_pins, pin_pitch_px

CONTACT_OVER_CORE = 1.25
"The core is 0.8 of the contact."
HALF_A_PITCH = 0.5
NATURAL_IMAGES = HornSchunckSettings(
    alpha=10.0, presmoothing_px=0.0, cell_px=1, sweeps=2, warp_above_px=0.0, pyramid_levels=6, warps=10, median_px=5
)
"For everyday scenes full of texture: no presmoothing, every pixel, full pyramid, median-filtered warps."


def dense() -> list[Method]:
    """The dense solver, on whole frames first."""
    return [
        horn_schunck_method("Horn-Schunck", HornSchunckSettings()),
        Method("casr", "Horn-Schunck, contact only", _contact_only, note="a square around the contact"),
    ]


def on_pins() -> list[Method]:
    """Affine motion from pins, as scores are made first."""
    return [
        Method("casr", "pins followed", _followed),
        Method("casr", "pins found in both frames", _detected, note="finds all pins twice"),
    ]


def horn_schunck_method(name: str, settings: HornSchunckSettings) -> Method:
    """The dense solver on whole frames, the frame before already prepared."""

    def prepare(first: Image, second: Image, core: Region) -> Run:
        solver = HornSchunck(settings)
        solver.start(first)
        # there and back again, so that every timed step sees a frame that moved
        frames = cycle((second, first))
        return lambda: solver.step(next(frames))

    return Method("casr", name, prepare)


def _contact_only(first: Image, second: Image, core: Region) -> Run:
    solver = HornSchunck()
    solver.start(first)
    frames, roi = cycle((second, first)), core.scaled(CONTACT_OVER_CORE).box(first.shape, margin_px=1)
    return lambda: solver.step(next(frames), roi)


def _followed(first: Image, second: Image, core: Region) -> Run:
    """As ``casr score`` does it."""
    tracker = PinTracker()
    start_px = tracker.start(first).centroids_px
    inside = core.contains(start_px)
    frames, before = cycle((second, first)), [start_px]

    def step() -> Affine:
        after = tracker.step(next(frames))
        last, before[0] = before[0], after
        return fit_affine(last[inside], after[inside])

    return step


def _detected(first: Image, second: Image, core: Region) -> Run:
    def pair() -> Affine:
        before, after = detect_pins(first).centroids_px, detect_pins(second).centroids_px
        i, j = match_pins(before, after, max_distance_px=HALF_A_PITCH * pin_pitch_px(before))
        inside = core.contains(before[i])
        return fit_affine(before[i[inside]], after[j[inside]])

    return pair
