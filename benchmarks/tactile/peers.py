"""Other people's optical flow, called the way their documentation says."""

from __future__ import annotations

import importlib
from itertools import cycle
from typing import Any

import cv2
import numpy as np

from benchmarks.tactile.jacobi import horn_schunck_jacobi
from benchmarks.tactile.method import Image, Method, Prepare
from benchmarks.tactile.timing import Run
from casr.flow.pin_engine import fit_affine
from casr.flow.region import Affine, Region
from casr.pins import detect_pins


def dense_peers() -> list[Method]:
    """Flow at every pixel; all of them, whether installed or not."""
    return [
        Method("OpenCV", "DIS ultrafast", _dis(cv2.DISOPTICAL_FLOW_PRESET_ULTRAFAST)),
        Method("OpenCV", "DIS fast", _dis(cv2.DISOPTICAL_FLOW_PRESET_FAST)),
        Method("OpenCV", "DIS medium", _dis(cv2.DISOPTICAL_FLOW_PRESET_MEDIUM)),
        Method("OpenCV", "Farneback, window 15", _farneback),
        Method("OpenCV", "PCAFlow", _contrib("createOptFlow_PCAFlow"), slow=True, needs="cv2.optflow"),
        Method("OpenCV", "DeepFlow", _contrib("createOptFlow_DeepFlow"), slow=True, needs="cv2.optflow"),
        Method("OpenCV", "DenseRLOF", _dense_rlof, slow=True, needs="cv2.optflow"),
        Method("NumPy", "Horn-Schunck, 100 Jacobi", _jacobi),
        Method("scikit-image", "ILK, radius 7", _skimage("optical_flow_ilk", radius=7), slow=True, needs="skimage"),
        Method("scikit-image", "TV-L1", _skimage("optical_flow_tvl1"), slow=True, needs="skimage"),
        Method("pyoptflow", "default", _pyoptflow(), slow=True, needs="pyoptflow"),
        Method("pyoptflow", "alpha 15, 100 iterations", _pyoptflow(alpha=15, Niter=100), slow=True, needs="pyoptflow"),
    ]


def pin_peers() -> list[Method]:
    """Lucas and Kanade's motion of the same pins, and the same affine fit."""
    return [
        Method("OpenCV", "PyrLK on all pins, default", _pyrlk(21, 3)),
        Method("OpenCV", "PyrLK on all pins, window 15", _pyrlk(15, 2)),
        Method(
            "OpenCV", "PyrLK on the contact's pins", _pyrlk(11, 1, contact_only=True), note="the contact's pins alone"
        ),
    ]


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


def _contrib(name: str) -> Prepare:
    def prepare(first: Image, second: Image, core: Region) -> Run:
        flow: Any = getattr(cv2.optflow, name)()
        return lambda: flow.calc(first, second, None)

    return prepare


def _dense_rlof(first: Image, second: Image, core: Region) -> Run:
    # it takes colour only
    colours = [cv2.cvtColor(image, cv2.COLOR_GRAY2BGR) for image in (first, second)]
    create: Any = getattr(cv2.optflow, "DenseRLOFOpticalFlow_create")  # noqa: B009  (not in the stubs)
    flow = create()
    return lambda: flow.calc(*colours, None)


def _farneback(first: Image, second: Image, core: Region) -> Run:
    settings = {"pyr_scale": 0.5, "levels": 3, "winsize": 15, "iterations": 3, "poly_n": 5, "poly_sigma": 1.2}
    call: Any = cv2.calcOpticalFlowFarneback
    return lambda: call(first, second, flow=None, flags=0, **settings)


def _jacobi(first: Image, second: Image, core: Region) -> Run:
    return lambda: horn_schunck_jacobi(first, second)


def _skimage(function: str, **options: Any) -> Prepare:
    def prepare(first: Image, second: Image, core: Region) -> Run:
        estimate = getattr(importlib.import_module("skimage.registration"), function)
        # their flow is (v, u)
        return lambda: np.stack(estimate(first, second, **options)[::-1], axis=-1)

    return prepare


def _pyoptflow(**options: Any) -> Prepare:
    def prepare(first: Image, second: Image, core: Region) -> Run:
        estimate = importlib.import_module("pyoptflow").HornSchunck
        return lambda: np.stack(estimate(first, second, **options), axis=-1)

    return prepare
