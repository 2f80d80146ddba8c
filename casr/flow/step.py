"""What goes into and comes out of every flow engine; its settings, which need no engine to be loaded."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Literal, Protocol

from casr.errors import SettingError
from casr.flow.region import Points, Region
from casr.images import Grey
from casr.pins import PinSettings
from casr.plugins import ENGINES, known_engines, plugin_named

SINGLE_FROM_ALPHA = 1.0
MOST_BAD_FRAMES = 2  # so many in a row are left out; one more ends the press


@dataclass(frozen=True, kw_only=True)
class HornSchunckSettings:
    """Settings of one flow estimate; the defaults suit the pins of a tactile sensor, about 9 px wide and 20 px apart.

    alpha : weight of smoothness, grey levels, as in Horn & Schunck's iteration on images of 0 to 255. A note says where
        it is not 0.2 to 10 times the frames' rms gradient per pixel: below, noise decides the flow between the pins;
        above, growth is lost (3 % at 10, 13 % at 24, 57 % at 80).
    presmoothing_px : standard deviation of the Gaussian both frames are smoothed with; 0 for none.
    cell_px : 1, 2 or 4: flow is solved for squares of this width from derivatives at every pixel, bilinear between.
    sweeps, cycles : Gauss-Seidel sweeps per half cycle, V-cycles per multigrid level.
    warp_above_px : largest component of flow, px, taken from one linearisation, if that explains the frames. 0: always
        warp; infinity: never.
    pyramid_levels : images, each half as large as the one before, that a longer flow is found on, coarse to fine. None:
        two, and more where the flow found does not take the second frame back to the first.
    warps : linearisations per pyramid level.
    median_px : width of the median filter over the flow after each of them, 3 or 5; 0 for none.
    support_px : border around a region of interest that is solved with it.
    precision : "single", "double", or "auto": single from ``SINGLE_FROM_ALPHA`` on, where it is 1e-5 px off at most;
        below, the gaps between pins hang on so little smoothness that its rounding decides the flow.
    SettingError : a setting out of range.
    """

    alpha: float = 30.0
    presmoothing_px: float = 1.5
    cell_px: int = 2
    sweeps: int = 1
    cycles: int = 1
    warp_above_px: float = 3.5
    pyramid_levels: int | None = None
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
        self._check("pyramid_levels", self.pyramid_levels is None or 1 <= self.pyramid_levels <= 16, "None or 1 to 16")
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


@dataclass(frozen=True, kw_only=True)
class FlowSettings:
    """How the growth of the contact region is measured.

    engine : one of ``ENGINES``: the pins of the region; dense flow by Horn and Schunck; dense flow by OpenCV's DIS; or
        an engine of another installed package by its name (``known_engines``).
    core_fraction : the fit looks at the region scaled by this about its centroid, 0 to 1. At the border the flow has
        a kink, which pins 20 px apart under-sample and every dense method rounds off.
    pins : for ``pin-affine``. horn_schunck : for that engine. dis_preset : for ``dis``.
    """

    engine: str = "pin-affine"
    core_fraction: float = 0.7
    pins: PinSettings = field(default_factory=PinSettings)
    horn_schunck: HornSchunckSettings = field(default_factory=HornSchunckSettings)
    dis_preset: str = "medium"

    def __post_init__(self) -> None:
        if self.engine not in ENGINES and plugin_named("casr.flow_engines", self.engine) is None:
            wanted, do = " or ".join(known_engines()), "Choose one of these engines, or install the one that you mean."
            raise SettingError("engine", wanted=wanted, found=repr(self.engine), do=do)
        if not 0 < self.core_fraction <= 1:
            found = repr(self.core_fraction)
            raise SettingError("core_fraction", wanted="above 0, at most 1", found=found, do="0.7 suits most presses.")


@dataclass(frozen=True)
class FlowStep:
    """How the contact region grew from one frame to the next.

    divergence : trace of the affine flow, 1/frame: D of the paper's eq. (1).
    log_growth : ln of the factor its area grows by; equal to the divergence in the limit of small steps.
    region : in the new frame. n : pins or pixels of the fit.
    notes : what a reader of the result should know of this step.
    """

    divergence: float
    log_growth: float
    region: Region
    n: int
    notes: tuple[str, ...] = ()


def notes_by_frame(frames: Iterable[int], steps: Iterable[FlowStep]) -> list[str]:
    """Each note of the steps once, with the frames, one for each step, that it belongs to."""
    found: dict[str, list[int]] = {}
    for frame, step in zip(frames, steps, strict=True):
        for note in step.notes:
            found.setdefault(note, []).append(frame)
    return [
        (f"frame {at[0]}" if len(at) == 1 else f"{len(at)} frames from {min(at)} to {max(at)}") + f": {note}"
        for note, at in found.items()
    ]


class Engine(Protocol):
    """One way to measure it; what a tracker drives."""

    def start(self, image: Grey, region: Region, pins_px: Points | None) -> None:
        """Take the first frame, the region in it and, where they are followed already, its pins (N, 2), px."""

    def step(self, image: Grey, pins_px: Points | None) -> FlowStep:
        """Take the next frame and, as at the start, its pins (N, 2), px."""
