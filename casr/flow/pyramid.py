"""Flow of any length: one linear problem where it is short, else a pyramid of frames, coarse to fine, with warping."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np

from casr.flow.coloured_grid import B1, B2, Floats, U, V, flow_of_cells, level, level_table, subtract_from_right
from casr.flow.multigrid import data_term, solve
from casr.flow.step import HornSchunckSettings
from casr.flow.warp import ENOUGH_PX, Unexplained, doubled, halved, unexplained, warp

FOUR_NEIGHBOURS = np.array([[0, 1, 0], [1, -4, 1], [0, 1, 0]], dtype=np.float64)
# a cell whose determinant drowns in rounding is solved as if it were this far from rank one
DET_FLOOR = {np.dtype(np.float32): 1e-6, np.dtype(np.float64): 1e-14}


@dataclass(frozen=True)
class _Solver:
    """How a linear problem is solved: cell size, weight of smoothness, effort."""

    cell_px: int
    smoothness: float
    sweeps: int
    cycles: int


class _Grid:
    """Work arrays for frames of one shape and type, used again for every pair."""

    def __init__(self, shape: tuple[int, ...], dtype: np.dtype[Any], solver: _Solver) -> None:
        self.shape, self.dtype, self._solver = shape, dtype, solver
        rows, columns = (-(-n // solver.cell_px) for n in shape)
        self._table = level_table(rows, columns)
        self._work = np.zeros(self._table[-1, 2], dtype)
        self._finest = level(self._work, self._table, 0)
        self._cells = np.zeros((rows, 2 * int(self._table[0, 1]), 2), dtype)
        self._sums = np.zeros((2, 5, self._cells.shape[1] * solver.cell_px), dtype)

    def flow(self, first: Floats, second: Floats, margin: int, start: Floats | None = None) -> Floats:
        """Flow (H, W, 2) from first to second, NaN pixels and margin px at the edges left out of the data.

        With a start, second is already warped along it, and the sum of start and what is left is returned.
        """
        solver, kind = self._solver, self.dtype.type
        data_term(first, second, margin, solver.cell_px, self._finest, self._sums)
        if start is not None:
            subtract_from_right(self._finest, kind(solver.smoothness) * self._roughness(start))
        lam = kind(solver.smoothness)
        solve(self._work, self._table, lam, kind(DET_FLOOR[self.dtype]), solver.sweeps, solver.cycles)
        flow_of_cells(self._finest, self._cells)
        flow = self._at_pixels()
        return flow if start is None else flow + start

    def left_grey(self, first: Floats, second: Floats, margin: int) -> float:
        """rms of what the last flow, found without a start, leaves of the data and costs in smoothness, grey levels.

        At the minimum that sum is the data at no flow plus the product of right-hand sides and flow.
        """
        inner = slice(margin, -margin), slice(margin, -margin)
        p, q, f = first[inner], second[inner], self._finest
        if p.size == 0:
            return 0.0
        won = sum(float(np.vdot(f[b], f[u])) for b, u in ((B1, U), (B2, V)))
        return math.sqrt(max(cv2.norm(p, q, cv2.NORM_L2SQR) + won, 0.0) / p.size)

    def _roughness(self, flow: Floats) -> Floats:
        """Five-point Laplacian of a flow averaged over cells."""
        height, width = self.shape
        size = self._solver.cell_px
        below, right = self._cells.shape[0] * size - height, self._cells.shape[1] * size - width
        cells = cv2.copyMakeBorder(flow, 0, below, 0, right, cv2.BORDER_REPLICATE)
        if size > 1:
            cells = cv2.resize(cells, self._cells.shape[1::-1], interpolation=cv2.INTER_AREA)
        return np.asarray(cv2.filter2D(cells, -1, FOUR_NEIGHBOURS, borderType=cv2.BORDER_REPLICATE), self.dtype)

    def _at_pixels(self) -> Floats:
        height, width = self.shape
        size = self._solver.cell_px
        if size == 1:
            return np.array(self._cells[:, :width])
        large = cv2.resize(self._cells, None, fx=size, fy=size, interpolation=cv2.INTER_LINEAR)
        return np.asarray(large[:height, :width], self.dtype)


# frames narrower than this are not halved again
SMALLEST_PX = 32
FEWEST_LEVELS = 2
MOST_SHAPES = 16


class Pyramid:
    """Finds the flow between two frames; keeps work arrays for the frame shapes it has met.

    Without a number of levels the pyramid grows until the flow explains the frames, or the frames end; the flow that
    leaves least unexplained is kept. More levels than the motion needs do harm: on coarse levels pins melt into a
    lattice that fits itself one pitch further.

    left : what the last flow does not explain; None where it was short enough for one linearisation.
    levels : of the pyramid that the last flow was found on.
    """

    def __init__(self, settings: HornSchunckSettings, dtype: np.dtype[Any]) -> None:
        self._settings, self._dtype = settings, dtype
        self._solver = _Solver(settings.cell_px, settings.alpha**2 / 3, settings.sweeps, settings.cycles)
        self._grids: dict[tuple[int, ...], _Grid] = {}
        self.left: Unexplained | None = None
        self.levels = 1

    def flow(self, first: Floats, second: Floats, margin: int, gradient: float) -> Floats:
        """Flow (H, W, 2) between smoothed frames (H, W) whose outermost margin px carry no data.

        gradient : rms of the frames', grey levels/px: what one linearisation leaves unexplained is measured by it.
        """
        limit = self._settings.warp_above_px
        if limit > 0:
            grid = self._grid(first.shape)
            flow = grid.flow(first, second, margin)
            short = longest_px(flow) <= limit and grid.left_grey(first, second, margin) <= ENOUGH_PX * gradient
            if short or limit == math.inf:
                self.left, self.levels = None, 1
                return flow
        fixed, most = self._settings.pyramid_levels, most_levels(first.shape)
        flow, self.left, self.levels = self._try(first, second, margin, fixed or min(FEWEST_LEVELS, most))
        for levels in range(self.levels + 1, 0 if fixed else most + 1):
            if not self.left.worth_another_level:
                break
            deeper = self._try(first, second, margin, levels)
            if deeper[1].clearly_less_than(self.left):
                flow, self.left, self.levels = deeper
        return flow

    def _try(self, first: Floats, second: Floats, margin: int, levels: int) -> tuple[Floats, Unexplained, int]:
        flow = self._coarse_to_fine(first, second, margin, levels)
        return flow, unexplained(first, second, flow, margin), levels

    def _grid(self, shape: tuple[int, ...]) -> _Grid:
        if shape not in self._grids:
            if len(self._grids) == MOST_SHAPES:
                self._grids.clear()
            self._grids[shape] = _Grid(shape, self._dtype, self._solver)
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


def most_levels(shape: tuple[int, ...]) -> int:
    """Levels of the deepest pyramid for frames of this shape."""
    side, levels = min(shape), 1
    while side >= SMALLEST_PX:
        side, levels = (side + 1) // 2, levels + 1
    return levels


def longest_px(flow: Floats) -> float:
    """Largest component of a flow (H, W, 2), px."""
    return cv2.norm(flow.reshape(len(flow), -1), cv2.NORM_INF)
