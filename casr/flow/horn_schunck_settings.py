"""Settings of the dense Horn-Schunck flow, apart from it so that they load without numba."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from casr.errors import SettingError

SINGLE_FROM_ALPHA = 1.0


@dataclass(frozen=True, kw_only=True)
class HornSchunckSettings:
    """Settings of one flow estimate; the defaults suit the pins of a tactile sensor, about 9 px wide and 20 px apart.

    Parameters
    ----------
    alpha : weight of smoothness, grey levels, as in Horn & Schunck's iteration on images of 0 to 255.
    presmoothing_px : standard deviation of the Gaussian both frames are smoothed with; 0 for none.
    cell_px : 1, 2 or 4: flow is solved for squares of this width from derivatives at every pixel, bilinear between.
    sweeps, cycles : Gauss-Seidel sweeps per half cycle, V-cycles per multigrid level.
    warp_above_px : largest component of flow, px, taken from one linearisation; 0 to warp always.
    pyramid_levels : images, each half as large as the one before, that a longer flow is found on, coarse to fine.
    warps : linearisations per pyramid level.
    median_px : width of the median filter over the flow after each of them, 3 or 5; 0 for none.
    support_px : border around a region of interest that is solved with it.
    precision : "single", "double", or "auto": single from ``SINGLE_FROM_ALPHA`` on, where it is 1e-5 px off at most;
        below, the gaps between pins hang on so little smoothness that its rounding decides the flow.

    Raises
    ------
    SettingError : a setting out of range.
    """

    alpha: float = 30.0
    presmoothing_px: float = 1.5
    cell_px: int = 2
    sweeps: int = 1
    cycles: int = 1
    warp_above_px: float = 3.5
    pyramid_levels: int = 2
    warps: int = 2
    median_px: int = 0
    support_px: int = 24
    precision: Literal["auto", "single", "double"] = "auto"

    def __post_init__(self) -> None:
        self._check("alpha", 1e-6 <= self.alpha <= 1e6, "1e-6 to 1e6")
        self._check("presmoothing_px", 0 <= self.presmoothing_px <= 50, "0 to 50")
        self._check("cell_px", self.cell_px in (1, 2, 4), "1, 2 or 4")
        self._check("sweeps", 1 <= self.sweeps <= 1000, "1 to 1000")
        self._check("cycles", 1 <= self.cycles <= 1000, "1 to 1000")
        self._check("warp_above_px", self.warp_above_px >= 0, "0 or more")
        self._check("pyramid_levels", 1 <= self.pyramid_levels <= 16, "1 to 16")
        self._check("warps", 1 <= self.warps <= 1000, "1 to 1000")
        self._check("median_px", self.median_px in (0, 3, 5), "0, 3 or 5")
        self._check("support_px", 0 <= self.support_px <= 10_000, "0 to 10000")
        self._check("precision", self.precision in ("auto", "single", "double"), '"auto", "single" or "double"')

    @property
    def single(self) -> bool:
        """Whether the flow is computed in single precision."""
        return self.precision == "single" or (self.precision == "auto" and self.alpha >= SINGLE_FROM_ALPHA)

    def _check(self, name: str, good: bool, wanted: str) -> None:
        if not good:
            found = str(getattr(self, name))
            raise SettingError(f"Horn-Schunck setting {name}", wanted=wanted, found=found, do="Change this setting.")

    @classmethod
    def natural_images(cls) -> HornSchunckSettings:
        """For everyday scenes full of texture: no presmoothing, every pixel, full pyramid, median-filtered warps."""
        return cls(
            alpha=10.0,
            presmoothing_px=0.0,
            cell_px=1,
            sweeps=2,
            warp_above_px=0.0,
            pyramid_levels=6,
            warps=10,
            median_px=5,
        )
