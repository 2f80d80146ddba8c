"""Errors of a method on one pair of frames."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.tactile.flow_pairs import FlowPair
from benchmarks.tactile.method import Method
from benchmarks.tactile.metrics import endpoint_error_px, percent_error
from casr.flow.dense_engine import mean_divergence
from casr.flow.region import Affine, Region

CORE_FRACTION = 0.8
"The core leaves out the edge of the contact, which pins 20 px apart cannot resolve."


def errors_of_pair(method: Method, pair: FlowPair) -> tuple[float, float]:
    """Error of the core's divergence, percent, and mean endpoint error in the contact, px."""
    core = core_of(pair)
    motion = method.prepare(pair.first, pair.second, core)()
    rows, columns = np.mgrid[: pair.first.shape[0], : pair.first.shape[1]]
    grid = np.stack([columns, rows], axis=-1).astype(np.float64)
    inside = pair.contact.depth(grid) < 1
    epe = endpoint_error_px(as_flow(motion, grid)[inside], pair.flow[inside]).mean()
    return float(percent_error(divergence_of(motion, core), pair.divergence)), float(epe)


def core_of(pair: FlowPair) -> Region:
    """The inner part of the contact, where divergence is judged."""
    return Region(pair.contact.polygon_px()).scaled(CORE_FRACTION)


def divergence_of(motion: Any, core: Region) -> float:
    """Mean divergence over the core, per frame pair."""
    return float(np.trace(motion.matrix)) if isinstance(motion, Affine) else mean_divergence(motion, core.polygon_px)


def as_flow(motion: Any, grid: NDArray[np.float64]) -> NDArray[Any]:
    """The motion as (H, W, 2) px at the pixels of ``grid`` (H, W, 2)."""
    return motion.displacement_px(grid) if isinstance(motion, Affine) else motion
