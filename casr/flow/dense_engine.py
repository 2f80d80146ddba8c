"""Flow engines on dense fields: the field around the contact region only, and the affine motion in the region's core."""

from __future__ import annotations

from dataclasses import replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from casr.flow.field_fit import fit_field
from casr.flow.region import Region
from casr.flow.step import FlowStep
from casr.images import Grey

SUPPORT_PX = 24.0


class DenseFlow(Protocol):
    """A dense method that keeps the frame before."""

    def start(self, image: Grey) -> object:
        """Take the first frame."""

    def step(self, image: Grey, roi: tuple[slice, slice]) -> NDArray[np.float32]:
        """(h, w, 2) flow from the frame before to this one, px, in these rows and columns."""


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
        roi = self._region.box(image.shape, margin_px=SUPPORT_PX)
        corner = np.array([roi[1].start, roi[0].start])
        core = self._region.scaled(self._core_fraction)
        fit = fit_field(self._method.step(image, roi), Region(core.polygon_px - corner))
        self._region = self._region.advanced(replace(fit, centre_px=fit.centre_px + corner))
        return FlowStep(fit.divergence, fit.log_growth, self._region, fit.n)
