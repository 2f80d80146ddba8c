"""Ways from two frames to a motion, this package's own and other people's, each behind one call."""

from __future__ import annotations

import importlib.util
from collections.abc import Callable
from dataclasses import dataclass
from itertools import cycle
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from casr.flow.horn_schunck import HornSchunck, HornSchunckSettings
from casr.flow.pin_engine import fit_affine
from casr.flow.region import Affine, Region
from casr.pins import PinTracker, detect_pins, match_pins, pin_pitch_px

Image = NDArray[np.uint8]
Run = Callable[[], Any]
Prepare = Callable[[Image, Image, Region], Run]


@dataclass(frozen=True)
class Method:
    """One way.

    Parameters
    ----------
    library, name : as printed.
    prepare : from first frame, second frame and the core of the contact to the call that is timed. What is done once
        per sequence, or belongs to the frame before, is done in ``prepare``. The first call gives the motion from the
        first to the second frame: a flow (H, W, 2) in px, or an ``Affine``.
    slow : scored on fewer seeds.
    needs : module to import, for peers that need not be there.
    note : where it does more or less than the others, what.
    """

    library: str
    name: str
    prepare: Prepare
    slow: bool = False
    needs: str = "cv2"
    note: str = ""

    @property
    def installed(self) -> bool:
        """Whether it can be run here."""
        return importlib.util.find_spec(self.needs) is not None


CONTACT_OVER_CORE = 1.25
"The core is 0.8 of the contact."
HALF_A_PITCH = 0.5
NATURAL_IMAGES = HornSchunckSettings(
    alpha=10.0, presmoothing_px=0.0, cell_px=1, sweeps=2, warp_above_px=0.0, pyramid_levels=6, warps=10, median_px=5
)
"For everyday scenes full of texture: no presmoothing, every pixel, full pyramid, median-filtered warps."


def dense() -> list[Method]:
    """Flow at every pixel: the dense solver on whole frames first, then others, whether installed or not."""
    return [
        Method("casr", "Horn-Schunck", _whole),
        Method("casr", "Horn-Schunck, contact only", _contact_only, note="a square around the contact"),
        Method("OpenCV", "expert: DIS, every second pixel, patches of 8 at 6", _tuned_dis(None)),
        Method(
            "OpenCV", "expert: DIS, the same around the contact", _tuned_dis(24), note="a square around the contact"
        ),
        Method("OpenCV", "DIS ultrafast", _dis(cv2.DISOPTICAL_FLOW_PRESET_ULTRAFAST)),
        Method("OpenCV", "DIS medium", _dis(cv2.DISOPTICAL_FLOW_PRESET_MEDIUM)),
        Method("scikit-image", "TV-L1", _tvl1, slow=True, needs="skimage"),
    ]


def on_pins() -> list[Method]:
    """Affine motion from pins, as scores are made first; then Lucas and Kanade's of the same pins, same fit."""
    return [
        Method("casr", "pins followed", _followed),
        Method("casr", "pins found in both frames", _detected, note="finds all pins twice"),
        Method("OpenCV", "expert: PyrLK on all pins, window 13, 2 levels", _pyrlk(13, 1)),
        Method("OpenCV", "PyrLK on all pins, window 15, 3 levels", _pyrlk(15, 2)),
        Method("OpenCV", "PyrLK on all pins, default", _pyrlk(21, 3)),
        Method(
            "OpenCV",
            "expert: PyrLK on the contact's pins",
            _pyrlk(13, 1, contact_only=True),
            note="the contact's pins alone",
        ),
    ]


def _whole(first: Image, second: Image, core: Region) -> Run:
    """The frame before already prepared."""
    solver = HornSchunck(HornSchunckSettings())
    solver.start(first)
    # there and back again, so that every timed step sees a frame that moved
    frames = cycle((second, first))
    return lambda: solver.step(next(frames))


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


def _dis(preset: int) -> Prepare:
    def prepare(first: Image, second: Image, core: Region) -> Run:
        flow: Any = cv2.DISOpticalFlow.create(preset)
        return lambda: flow.calc(first, second, None)

    return prepare


def _pyrlk(window_px: int, most_level: int, *, contact_only: bool = False) -> Prepare:
    """Lucas and Kanade's on pins whose places in the first frame are known, and the affine fit of this package."""

    def prepare(first: Image, second: Image, core: Region) -> Run:
        pins_px = detect_pins(first).centroids_px
        inside = core.contains(pins_px)
        if contact_only:
            pins_px, inside = pins_px[inside], inside[inside]
        frames = cycle(((first, second), (second, first)))
        places = [np.ascontiguousarray(pins_px, dtype=np.float32)]
        call: Any = cv2.calcOpticalFlowPyrLK
        window, stop = (window_px, window_px), (cv2.TERM_CRITERIA_COUNT + cv2.TERM_CRITERIA_EPS, 30, 0.01)

        def step() -> Affine:
            before, after = next(frames)
            found, seen, _ = call(before, after, places[0], None, winSize=window, maxLevel=most_level, criteria=stop)
            rows = inside & (seen.ravel() == 1)
            last, places[0] = places[0], found
            return fit_affine(last[rows], found[rows])

        return step

    return prepare


def _tuned_dis(margin_px: int | None) -> Prepare:
    """DIS whose finest grid is every second pixel, searched for eight steps, and which smooths nothing; of the square
    around the contact alone where a margin is given."""

    def prepare(first: Image, second: Image, core: Region) -> Run:
        top, left, bottom, right = (0, 0, *first.shape)
        if margin_px is not None:
            top, left, bottom, right = core.scaled(CONTACT_OVER_CORE).box(first.shape, margin_px=margin_px)
        square = slice(top, bottom), slice(left, right)
        flow: Any = cv2.DISOpticalFlow.create(cv2.DISOPTICAL_FLOW_PRESET_ULTRAFAST)
        flow.setFinestScale(1)
        flow.setPatchStride(6)
        flow.setGradientDescentIterations(8)
        found = np.zeros((*first.shape, 2), np.float32)

        def run() -> NDArray[np.float32]:
            found[square] = flow.calc(first[square].copy(), second[square].copy(), None)
            return found

        return run

    return prepare


def _tvl1(first: Image, second: Image, core: Region) -> Run:
    estimate = importlib.import_module("skimage.registration").optical_flow_tvl1
    # their flow is (v, u)
    return lambda: np.stack(estimate(first, second)[::-1], axis=-1)
