"""What goes into and comes out of every flow engine."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Protocol

from casr.errors import SettingError
from casr.flow.horn_schunck_settings import HornSchunckSettings
from casr.flow.region import Region
from casr.images import Grey
from casr.pins import PinSettings

ENGINES = ("pin-affine", "horn-schunck", "dis")


@dataclass(frozen=True, kw_only=True)
class FlowSettings:
    """How the growth of the contact region is measured.

    Parameters
    ----------
    engine : one of ``ENGINES``: the pins of the region; dense flow by Horn and Schunck; dense flow by OpenCV's DIS.
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
        if self.engine not in ENGINES:
            raise SettingError("engine", wanted=" or ".join(ENGINES), found=repr(self.engine), do="Choose one.")
        if not 0 < self.core_fraction <= 1:
            found = repr(self.core_fraction)
            raise SettingError("core_fraction", wanted="above 0, at most 1", found=found, do="0.7 suits most presses.")


@dataclass(frozen=True)
class FlowStep:
    """How the contact region grew from one frame to the next.

    Parameters
    ----------
    divergence : trace of the affine flow, 1/frame: D of the paper's eq. (1).
    log_growth : ln of the factor its area grows by; equal to the divergence in the limit of small steps.
    region : in the new frame.
    n : pins or pixels of the fit.
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
    return [f"{_named(where)}: {note}" for note, where in found.items()]


def _named(where: list[int]) -> str:
    return f"frame {where[0]}" if len(where) == 1 else f"{len(where)} frames from {min(where)} to {max(where)}"


class Engine(Protocol):
    """One way to measure it; what a tracker drives."""

    def start(self, image: Grey, region: Region) -> None:
        """Take the first frame and the region in it."""

    def step(self, image: Grey) -> FlowStep:
        """Take the next frame."""
