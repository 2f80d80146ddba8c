"""Dense optical flow after Horn & Schunck (Artificial Intelligence 17:185-203, 1981), solved by full multigrid.

Minimises, over all pixels, (Ix u + Iy v + It)^2 + alpha^2 / 3 |grad (u, v)|^2. With the five-point Laplacian this is
the paper's iteration (its section 12) at convergence: there alpha^2 weighs (mean of neighbours - flow), a third of the
Laplacian. Derivatives are the mean of both frames' five-point central differences, after smoothing by a Gaussian.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import cv2
import numpy as np
from numpy.typing import NDArray

from casr.errors import ImageError, SettingError
from casr.flow.compiled import Floats
from casr.flow.linear_flow import Grid, Solver
from casr.flow.warp import doubled, halved, warp
from casr.images import as_grey

Box = tuple[int, int, int, int]
# frames below this are not halved
SMALLEST_PX = 32


@dataclass(frozen=True, kw_only=True)
class HornSchunckSettings:
    """Settings of one flow estimate; the defaults suit the pins of a tactile sensor (about 9 px wide, 20 px apart).

    alpha : weight of smoothness in grey levels, as in Horn & Schunck's iteration on 0..255 images.
    presmoothing_px : standard deviation of the Gaussian applied to both frames; 0 for none.
    cell_px : flow is solved for squares of 1, 2 or 4 px from derivatives of every pixel, and interpolated between.
    sweeps, cycles : Gauss-Seidel sweeps per half cycle and V-cycles per multigrid level.
    warp_above_px : longest flow taken from one linearisation; 0 always warps.
    warps : linearisations per pyramid level once the flow is longer.
    pyramid_levels : images, each half as large, used once the flow is longer; 1 is the frame itself.
    median_px : width (0, 3 or 5) of the median filter over the flow after each warp.
    support_px : frame around a region of interest that is solved with it.
    precision : "single" or "double".
    """

    alpha: float = 30.0
    presmoothing_px: float = 1.5
    cell_px: int = 2
    sweeps: int = 1
    cycles: int = 1
    warp_above_px: float = 3.5
    warps: int = 1
    pyramid_levels: int = 3
    median_px: int = 0
    support_px: int = 24
    precision: Literal["single", "double"] = "single"

    def __post_init__(self) -> None:
        _check("alpha", self.alpha, 1e-6 <= self.alpha <= 1e6, "1e-6 to 1e6")
        _check("presmoothing_px", self.presmoothing_px, 0 <= self.presmoothing_px <= 50, "0 to 50")
        _check("cell_px", self.cell_px, self.cell_px in (1, 2, 4), "1, 2 or 4")
        _check("sweeps", self.sweeps, 1 <= self.sweeps <= 1000, "1 to 1000")
        _check("cycles", self.cycles, 1 <= self.cycles <= 1000, "1 to 1000")
        _check("warp_above_px", self.warp_above_px, self.warp_above_px >= 0, "0 or more")
        _check("warps", self.warps, 1 <= self.warps <= 1000, "1 to 1000")
        _check("pyramid_levels", self.pyramid_levels, 1 <= self.pyramid_levels <= 16, "1 to 16")
        _check("median_px", self.median_px, self.median_px in (0, 3, 5), "0, 3 or 5")
        _check("support_px", self.support_px, 0 <= self.support_px <= 10_000, "0 to 10000")
        _check("precision", self.precision, self.precision in ("single", "double"), '"single" or "double"')

    @classmethod
    def natural_images(cls) -> HornSchunckSettings:
        """Everyday scenes: full pyramid, many warps, median filtering of the flow between them."""
        return cls(
            alpha=10.0,
            presmoothing_px=0.0,
            cell_px=1,
            sweeps=2,
            cycles=2,
            warp_above_px=0.0,
            warps=10,
            pyramid_levels=5,
            median_px=5,
        )


def _check(name: str, value: object, good: bool, wanted: str) -> None:
    if not good:
        raise SettingError(f"Horn-Schunck setting {name}", wanted=wanted, found=str(value), do="Change this setting.")


class HornSchunck:
    """Flow of every frame of a sequence against the one before; each frame is prepared once."""

    def __init__(self, settings: HornSchunckSettings = HornSchunckSettings()) -> None:
        self.settings = settings
        self._dtype = np.dtype(np.float32 if settings.precision == "single" else np.float64)
        self._solver = Solver(settings.cell_px, settings.alpha**2 / 3, settings.sweeps, settings.cycles)
        # smoothing has mixed the pixels nearest the edge with what is not there
        self._margin = max(2, int(np.ceil(2 * settings.presmoothing_px)))
        self._grids: dict[tuple[int, int], Grid] = {}
        self._image: NDArray[Any] | None = None
        self._smooth: tuple[Box, Floats] | None = None

    def start(self, image: NDArray[Any]) -> None:
        """Take the first frame."""
        self._image, self._smooth = as_grey(image, where="first frame").copy(), None

    def step(self, image: NDArray[Any], roi: Box | None = None) -> Floats:
        """Flow from the frame before to this one.

        Parameters
        ----------
        image : (H, W) frame, of the shape of the one before.
        roi : (x0, y0, x1, y1) px, half open: pixels whose flow is wanted. They and ``support_px`` around are solved.

        Returns
        -------
        (H, W, 2) flow (u right, v down) px, NaN outside the solved box; float64 for double precision, else float32.

        Raises
        ------
        ImageError : not a frame, another shape than the frame before, no frame before, or an empty region.
        """
        image = as_grey(image, where="second frame")
        if self._image is None or image.shape != self._image.shape:
            raise ImageError(
                "second frame",
                wanted="two frames of one shape",
                found=f"{None if self._image is None else self._image.shape} and {image.shape}",
                do="Give start() a frame of the same camera first.",
            )
        box = self._box(image.shape, roi)
        if self._smooth is None or self._smooth[0] != box:
            self._smooth = box, self._smoothed(self._image, box)
        second = self._smoothed(image, box)
        flow = self._flow(self._smooth[1], second)
        self._image, self._smooth = image.copy(), (box, second)
        return _placed(flow, box, image.shape)

    def _box(self, shape: tuple[int, ...], roi: Box | None) -> Box:
        """Region of interest and its support, its edges on multiples of 16 px so that work arrays serve again."""
        height, width = shape
        if roi is None:
            return 0, 0, width, height
        x0, y0, x1, y1 = roi
        x0, y0, x1, y1 = max(x0, 0), max(y0, 0), min(x1, width), min(y1, height)
        if x0 >= x1 or y0 >= y1:
            raise ImageError(
                "region of interest",
                wanted=f"a box (x0, y0, x1, y1) inside {width} x {height} px",
                found=str(roi),
                do="Check the region.",
            )
        margin, step = self.settings.support_px, 16
        low = [max((n - margin) // step * step, 0) for n in (x0, y0)]
        high = [-(-(n + margin) // step) * step for n in (x1, y1)]
        return low[0], low[1], min(high[0], width), min(high[1], height)

    def _smoothed(self, image: NDArray[Any], box: Box) -> Floats:
        sigma = self.settings.presmoothing_px
        reach = int(np.ceil(4 * sigma))
        x0, y0, x1, y1 = box
        left, top = min(reach, x0), min(reach, y0)
        part = image[y0 - top : y1 + reach, x0 - left : x1 + reach]
        if sigma == 0:
            return part.astype(self._dtype)
        kernel = cv2.getGaussianKernel(2 * reach + 1, sigma)
        depth = cv2.CV_32F if self._dtype == np.float32 else cv2.CV_64F
        smooth = cv2.sepFilter2D(part, depth, kernel, kernel, borderType=cv2.BORDER_REPLICATE)
        return np.ascontiguousarray(smooth[top : top + y1 - y0, left : left + x1 - x0])

    def _grid(self, shape: tuple[int, int]) -> Grid:
        if shape not in self._grids:
            if len(self._grids) >= 16:
                self._grids.clear()
            self._grids[shape] = Grid(shape, self._dtype, self._solver)
        return self._grids[shape]

    def _flow(self, first: Floats, second: Floats) -> Floats:
        limit = self.settings.warp_above_px
        if limit > 0:
            flow = self._grid(first.shape).flow(first, second, self._margin)
            if np.abs(flow).max() <= limit:
                return flow
        return self._warped_flow(first, second, self._margin, self.settings.pyramid_levels)

    def _warped_flow(self, first: Floats, second: Floats, margin: int, levels: int) -> Floats:
        """Coarse to fine: start from the flow of the halved frames, warp, solve for what is left, again."""
        grid, flow = self._grid(first.shape), None
        if levels > 1 and min(first.shape) >= SMALLEST_PX:
            coarse = self._warped_flow(halved(first), halved(second), (margin + 1) // 2 + 1, levels - 1)
            flow = doubled(coarse, first.shape)
        for _ in range(self.settings.warps):
            if flow is None:
                flow = grid.flow(first, second, margin)
            else:
                flow = grid.flow(first, warp(second, flow, margin), margin, flow)
            flow = _median(flow, self.settings.median_px)
        return flow


def _median(flow: Floats, width: int) -> Floats:
    if width == 0:
        return flow
    planes = [cv2.medianBlur(np.ascontiguousarray(flow[..., p], dtype=np.float32), width) for p in range(2)]
    return np.stack(planes, axis=-1).astype(flow.dtype)


def _placed(flow: Floats, box: Box, shape: tuple[int, ...]) -> Floats:
    if flow.shape[:2] == shape:
        return flow
    out = np.full((*shape, 2), np.nan, flow.dtype)
    out[box[1] : box[3], box[0] : box[2]] = flow
    return out


def horn_schunck(
    first: NDArray[Any],
    second: NDArray[Any],
    *,
    settings: HornSchunckSettings = HornSchunckSettings(),
    roi: Box | None = None,
) -> Floats:
    """Flow (H, W, 2) from first to second; see :meth:`HornSchunck.step`."""
    engine = HornSchunck(settings)
    engine.start(first)
    return engine.step(second, roi)
