"""Flow of any length: one linear problem where it is short, else a pyramid of frames, coarse to fine, with warping."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np

from casr.flow.compiled import Floats
from casr.flow.horn_schunck_settings import HornSchunckSettings
from casr.flow.linear_flow import Grid, Solver
from casr.flow.warp import doubled, halved, warp

# frames narrower than this are not halved again
SMALLEST_PX = 32
MOST_SHAPES = 16


class Pyramid:
    """Finds the flow between two frames; keeps work arrays for the frame shapes it has met."""

    def __init__(self, settings: HornSchunckSettings, dtype: np.dtype[Any]) -> None:
        self._settings, self._dtype = settings, dtype
        self._solver = Solver(settings.cell_px, settings.alpha**2 / 3, settings.sweeps, settings.cycles)
        self._grids: dict[tuple[int, ...], Grid] = {}

    def flow(self, first: Floats, second: Floats, margin: int) -> Floats:
        """Flow (H, W, 2) between smoothed frames (H, W) whose outermost margin px carry no data."""
        limit = self._settings.warp_above_px
        if limit > 0:
            flow = self._grid(first.shape).flow(first, second, margin)
            if np.abs(flow).max() <= limit:
                return flow
        return self._coarse_to_fine(first, second, margin, self._settings.pyramid_levels)

    def _grid(self, shape: tuple[int, ...]) -> Grid:
        if shape not in self._grids:
            if len(self._grids) == MOST_SHAPES:
                self._grids.clear()
            self._grids[shape] = Grid(shape, self._dtype, self._solver)
        return self._grids[shape]

    def _coarse_to_fine(self, first: Floats, second: Floats, margin: int, levels: int) -> Floats:
        grid = self._grid(first.shape)
        if levels > 1 and min(first.shape) >= SMALLEST_PX:
            # halving mixes in one pixel more
            coarse = self._coarse_to_fine(halved(first), halved(second), (margin + 1) // 2 + 1, levels - 1)
            flow = doubled(coarse, first.shape)
            rounds = self._settings.warps
        else:
            flow = self._filtered(grid.flow(first, second, margin))
            rounds = self._settings.warps - 1
        for _ in range(rounds):
            flow = self._filtered(grid.flow(first, warp(second, flow, margin), margin, flow))
        return flow

    def _filtered(self, flow: Floats) -> Floats:
        width = self._settings.median_px
        if width == 0:
            return flow
        # OpenCV's median of floats is in single precision
        planes = [cv2.medianBlur(np.ascontiguousarray(flow[..., p], dtype=np.float32), width) for p in range(2)]
        return np.stack(planes, axis=-1).astype(flow.dtype)
