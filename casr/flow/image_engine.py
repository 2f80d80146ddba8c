"""Dense flow over the whole image: its mean divergence is D of the paper's eq. (1) where no region is chosen."""

from __future__ import annotations

from casr.flow.dense_engine import DenseFlow
from casr.flow.divergence import divergence
from casr.flow.region import Points, Region
from casr.flow.step import FlowStep
from casr.images import Grey

DOUBT = (
    "growth is the mean divergence of the whole image: what lies outside the contact counts as much as the contact, so "
    "that it depends on how the frames are cropped"
)


class ImageEngine:
    """Solves all of the image and takes the mean; the contact region stays where it is, for pictures only."""

    def __init__(self, method: DenseFlow) -> None:
        self._method = method

    def start(self, image: Grey, region: Region, pins_px: Points | None) -> None:
        self._method.start(image)
        self._region = region
        self._start_notes: tuple[str, ...] = (DOUBT,)

    def step(self, image: Grey, pins_px: Points | None) -> FlowStep:
        height, width = image.shape
        flow = self._method.step(image, (0, 0, width, height))
        mean = float(divergence(flow.astype("float32", copy=False)).mean())
        notes, self._start_notes = (*self._start_notes, *self._method.notes), ()
        return FlowStep(mean, mean, self._region, height * width, notes)
