"""The front door of flow: follow a contact region through frames and say how fast it grows, by the engine chosen."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from numpy.typing import NDArray

from casr.errors import ImageError, SettingError
from casr.flow.dense_engine import DenseEngine, DenseFlow
from casr.flow.dis import Dis
from casr.flow.image_engine import ImageEngine
from casr.flow.pin_engine import PinEngine
from casr.flow.plugin_engine import PluginEngine
from casr.flow.region import Points, Region
from casr.flow.step import ENGINES, Engine, FlowSettings, FlowStep
from casr.images import as_grey

__all__ = ["ENGINES", "FlowSettings", "FlowStep", "FlowTracker", "dense_flow"]


LOST_PERCENT = {"horn-schunck": (35, 12), "dis": (40, 18)}
"""Most that dense flow loses of the growth of a contact, below and from two pin pitches of radius: the worst of 80
presses of ``emg2vsa tools bench growth`` at 1.25 and at 2 pitches, with dirt that stays where it is. On clean skin it
is a third to a half of that, and 1 % from 3 pitches."""


class FlowTracker:
    """Follows one contact region; holds a copy of the frame before.

    Parameters
    ----------
    settings : engine and its settings.
    whole_image : take the mean divergence of all of the image instead of the region's growth.

    Raises
    ------
    SettingError : the whole image by an engine that is not dense, or of another package.
    PluginError : an engine of another package cannot be used.
    """

    def __init__(self, settings: FlowSettings | None = None, *, whole_image: bool = False) -> None:
        self.settings = settings or FlowSettings()
        self._engine = _of_image(self.settings) if whole_image else _engine(self.settings)
        self._shape: tuple[int, ...] | None = None

    def start(self, image: NDArray[Any], region: Region, pins_px: Points | None = None) -> None:
        """Take the frame of first contact and the contact region in it.

        Parameters
        ----------
        pins_px : (N, 2) places of its pins, NaN where one is lost, if somebody follows them already; every ``step`` is
            then given the same pins. None: ``pin-affine`` follows those it needs by itself.

        Raises
        ------
        PinsError : too few pins in reach of the region (``pin-affine``).
        SettingError : the region lies outside the image.
        ImageError : not an image.
        """
        grey = as_grey(image)
        self._shape = grey.shape
        self._engine.start(grey, region, pins_px)

    def step(self, image: NDArray[Any], pins_px: Points | None = None) -> FlowStep:
        """Growth of the region from the frame before to this one. Identical frames give exactly 0.

        Raises
        ------
        PinsError : too few of the region's pins are left (``pin-affine``).
        ImageError : not an image, another size than the first, or nothing was started.
        """
        grey = as_grey(image)
        if grey.shape != self._shape:
            wanted = "a first frame: call start" if self._shape is None else f"frames of one shape, {self._shape}"
            raise ImageError("frame", wanted=wanted, found=f"shape {grey.shape}", do="Give frames of one recording.")
        return self._engine.step(grey, pins_px)


def _engine(settings: FlowSettings) -> Engine:
    if settings.engine == "pin-affine":
        return PinEngine(settings)
    if settings.engine not in ENGINES:
        return PluginEngine(settings)
    return DenseEngine(dense_flow(settings), settings.core_fraction, doubt_of(settings.engine))


def _of_image(settings: FlowSettings) -> Engine:
    if settings.engine not in LOST_PERCENT:
        raise SettingError(
            "region image",
            wanted="a dense engine, horn-schunck or dis",
            found=f"{settings.engine}, which follows a region",
            do="Choose one with engine (--engine dis), or leave the region to be found.",
        )
    return ImageEngine(dense_flow(settings))


def dense_flow(settings: FlowSettings) -> DenseFlow:
    """The dense method of ``settings.engine``, one of ``LOST_PERCENT``."""
    if settings.engine == "dis":
        return Dis(settings.dis_preset)
    # loaded when used: it compiles its kernels with numba, which the other engines never need and may be absent
    method: DenseFlow = import_module("casr.flow.horn_schunck").HornSchunck(settings.horn_schunck)
    return method


def doubt_of(engine: str) -> str:
    """What every score with this dense engine says of itself."""
    small, large = LOST_PERCENT[engine]
    return (
        f"dense flow ({engine}) may lose {small} % of the growth of a contact below 2 pin pitches of radius, "
        f"{large} % above; pin-affine is within 5 % where pins are seen"
    )
