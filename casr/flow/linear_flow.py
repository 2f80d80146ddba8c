"""One linear Horn-Schunck problem: the flow increment that two frames, already smoothed and warped, ask for."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np

from casr.flow.brightness import data_term
from casr.flow.coloured_grid import flow_of_cells, level, level_table, subtract_from_right
from casr.flow.compiled import Floats
from casr.flow.multigrid import solve

FOUR_NEIGHBOURS = np.array([[0, 1, 0], [1, -4, 1], [0, 1, 0]], dtype=np.float64)
# a cell whose determinant drowns in rounding is solved as if it were this far from rank one
DET_FLOOR = {np.dtype(np.float32): 1e-6, np.dtype(np.float64): 1e-14}


@dataclass(frozen=True)
class Solver:
    """How a linear problem is solved: cell size, weight of smoothness, effort."""

    cell_px: int
    smoothness: float
    sweeps: int
    cycles: int


class Grid:
    """Work arrays for frames of one shape and type, used again for every pair."""

    def __init__(self, shape: tuple[int, ...], dtype: np.dtype[Any], solver: Solver) -> None:
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
