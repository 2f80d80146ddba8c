"""Other people's dense optical flow, called the way their documentation says."""

from __future__ import annotations

import importlib
from typing import Any

import cv2
import numpy as np

from benchmarks.tactile.jacobi import horn_schunck_jacobi
from benchmarks.tactile.method import Image, Method, Prepare
from benchmarks.tactile.timing import Run
from casr.flow.region import Region


def peers() -> list[Method]:
    """All of them, whether installed or not."""
    return [
        Method("OpenCV DIS ultrafast", _dis(cv2.DISOPTICAL_FLOW_PRESET_ULTRAFAST)),
        Method("OpenCV DIS fast", _dis(cv2.DISOPTICAL_FLOW_PRESET_FAST)),
        Method("OpenCV DIS medium", _dis(cv2.DISOPTICAL_FLOW_PRESET_MEDIUM)),
        Method("OpenCV Farneback, window 15", _farneback),
        Method("NumPy Horn-Schunck, 100 Jacobi", _jacobi),
        Method("scikit-image ILK, radius 7", _skimage("optical_flow_ilk", radius=7), slow=True, needs="skimage"),
        Method("scikit-image TV-L1", _skimage("optical_flow_tvl1"), slow=True, needs="skimage"),
        Method("pyoptflow, default", _pyoptflow(), slow=True, needs="pyoptflow"),
        Method("pyoptflow, alpha 15, 100 it.", _pyoptflow(alpha=15, Niter=100), slow=True, needs="pyoptflow"),
    ]


def _dis(preset: int) -> Prepare:
    def prepare(first: Image, second: Image, core: Region) -> Run:
        flow: Any = cv2.DISOpticalFlow.create(preset)
        return lambda: flow.calc(first, second, None)

    return prepare


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
