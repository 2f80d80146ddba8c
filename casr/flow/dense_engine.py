"""Flow engines on dense fields: the field around the contact region only, and the affine motion in its core."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from casr.flow.field_fit import fit_field
from casr.flow.region import Region
from casr.flow.step import FlowStep
from casr.images import Grey

Box = tuple[int, int, int, int]


class DenseFlow(Protocol):
    """A dense method that keeps the frame before."""

    def start(self, image: Grey) -> None:
        """Take the first frame."""

    def step(self, image: Grey, roi: Box) -> NDArray[np.floating[Any]]:
        """(H, W, 2) flow from the frame before to this one, px, good in the box (x0, y0, x1, y1)."""


class DenseEngine:
    """Solves the box around the region, fits the core and moves the region along.

    Parameters
    ----------
    method : gives the flow.
    core_fraction : share of the region, about its centroid, that the fit looks at.
    """

    def __init__(self, method: DenseFlow, core_fraction: float) -> None:
        self._method, self._core_fraction = method, core_fraction

    def start(self, image: Grey, region: Region) -> None:
        region.box(image.shape)  # a region outside the image is an error of the first frame
        self._method.start(image)
        self._region = region

    def step(self, image: Grey) -> FlowStep:
        core = self._region.scaled(self._core_fraction)
        fit = fit_field(self._method.step(image, core.box(image.shape)), core)
        before, self._region = self._region, self._region.advanced(fit)
        return FlowStep(*before.growth_to(self._region), self._region, fit.n)
