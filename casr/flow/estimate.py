"""The front door of flow: follow a contact region through frames and say how fast it grows, by the engine chosen.

Engines of other installed packages are entry points of ``casr.flow_engines``, each a callable that makes one:
``engine(settings)`` gets the `FlowSettings` and returns an `Engine` (``casr.flow.step``). What it returns and raises is
looked at in every step, so that a fault of it is told as one.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from casr.by_name import module_named
from casr.errors import CasrError, FramesError, ImageError, PinsError, SettingError, said_by, said_of
from casr.flow.dense_engine import DenseEngine, DenseFlow, Dis, ImageEngine
from casr.flow.pin_engine import PinEngine, need_pins_inside
from casr.flow.region import Points, Region
from casr.flow.step import MOST_BAD_FRAMES, FlowSettings, FlowStep, notes_by_frame
from casr.frames import FrameSequence
from casr.images import Grey, as_grey
from casr.pins import detect_pins, pins_in_doubt
from casr.plugins import ENGINES, plugin_named


class PluginEngine:
    """The engine of another package that ``settings.engine`` names.

    PluginError : it cannot be imported or made; in ``start`` and ``step``, it failed or broke its contract.
    """

    def __init__(self, settings: FlowSettings) -> None:
        plugin = plugin_named("casr.flow_engines", settings.engine)
        assert plugin is not None, settings  # which the settings have looked at
        self._plugin = plugin
        self.start_notes = (f"growth is measured by the flow engine {self._plugin}",)
        make = self._plugin.load()
        with self._faults("an engine that can be made"):
            self._engine: Any = make(settings)

    def start(self, image: Grey, region: Region, pins_px: Points | None) -> None:
        """``Engine.start`` of the other package, pins (N, 2) px. PluginError : it failed."""
        with self._faults("an engine that takes the first frame"):
            self._engine.start(image, region, pins_px)

    def step(self, image: Grey, pins_px: Points | None) -> FlowStep:
        """``Engine.step`` of the other package, pins (N, 2) px. PluginError : it failed, or what it returned is no
        finite FlowStep."""
        with self._faults("an engine that takes the next frame"):
            step = self._engine.step(image, pins_px)
        if not isinstance(step, FlowStep) or not np.isfinite([step.divergence, step.log_growth]).all():
            raise self._plugin.fault("a FlowStep with finite growth from step", repr(step)[:80])
        return step

    @contextmanager
    def _faults(self, wanted: str) -> Iterator[None]:
        try:
            yield
        except CasrError:
            raise
        except Exception as error:  # of foreign code, which may stumble over anything
            raise self._plugin.fault(wanted, said_by(error)) from error


__all__ = ["ENGINES", "FlowSettings", "FlowStep", "FlowTracker", "dense_flow"]


LOST_PERCENT = {"horn-schunck": (35, 12), "dis": (40, 18)}
"""Most that dense flow loses of the growth of a contact, below and from two pin pitches of radius: the worst of 80
presses of ``emg2vsa tools bench growth`` at 1.25 and at 2 pitches, with dirt that stays where it is. On clean skin it
is a third to a half of that, and 1 % from 3 pitches."""


class FlowTracker:
    """Follows one contact region; holds a copy of the frame before.

    settings : engine and its settings.
    whole_image : take the mean divergence of all of the image instead of the region's growth.
    SettingError : the whole image by an engine that is not dense, or of another package.
    PluginError : an engine of another package cannot be used.
    """

    def __init__(self, settings: FlowSettings | None = None, *, whole_image: bool = False) -> None:
        self.settings = settings or FlowSettings()
        self._engine = _engine(self.settings, whole_image)
        self._shape: tuple[int, ...] | None = None

    def start(self, image: NDArray[Any], region: Region, pins_px: Points | None = None) -> None:
        """Take the frame of first contact and the contact region in it.

        pins_px : (N, 2) places of its pins, NaN where one is lost, if somebody follows them already; every ``step`` is
            then given the same pins. None: ``pin-affine`` follows those it needs by itself.
        PinsError : too few pins in reach of the region (``pin-affine``).
        SettingError : the region lies outside the image. ImageError : not an image.
        """
        grey = as_grey(image)
        self._shape = grey.shape
        self._engine.start(grey, region, pins_px)
        self._start_notes = self._engine.start_notes

    def step(self, image: NDArray[Any], pins_px: Points | None = None) -> FlowStep:
        """Growth of the region from the frame before to this one. Identical frames give exactly 0.

        image : (H, W) or (H, W, 3). pins_px : (N, 2) px, where they are followed already.
        PinsError : too few of the region's pins are left (``pin-affine``).
        ImageError : not an image, another size than the first, or nothing was started.
        """
        grey = as_grey(image)
        if grey.shape != self._shape:
            wanted = "a first frame: call start" if self._shape is None else f"frames of one shape, {self._shape}"
            raise ImageError("frame", wanted=wanted, found=f"shape {grey.shape}", do="Give frames of one recording.")
        step = self._engine.step(grey, pins_px)
        notes, self._start_notes = (*self._start_notes, *step.notes), ()
        return replace(step, notes=notes)


def _engine(settings: FlowSettings, whole_image: bool) -> PinEngine | DenseEngine | ImageEngine | PluginEngine:
    if whole_image and settings.engine not in LOST_PERCENT:
        raise SettingError(
            "region image", wanted="a dense engine, horn-schunck or dis",
            found=f"{settings.engine}, which follows a region",
            do="Choose one with engine (--engine dis), or leave the region to be found.",
        )  # fmt: skip
    if whole_image:
        return ImageEngine(dense_flow(settings))
    if settings.engine == "pin-affine":
        return PinEngine(settings)
    if settings.engine not in ENGINES:
        return PluginEngine(settings)
    return DenseEngine(dense_flow(settings), settings.core_fraction, doubt_of(settings.engine))


def dense_flow(settings: FlowSettings) -> DenseFlow:
    """The dense method of ``settings.engine``, one of ``LOST_PERCENT``."""
    if settings.engine == "dis":
        return Dis(settings.dis_preset)
    # loaded when used: it compiles its kernels with numba, which the other engines never need and may be absent
    method: DenseFlow = module_named("casr.flow.horn_schunck").HornSchunck(settings.horn_schunck)
    return method


def doubt_of(engine: str) -> str:
    """What every score with this dense engine says of itself."""
    small, large = LOST_PERCENT[engine]
    return (
        f"dense flow ({engine}) may lose {small} % of the growth of a contact below 2 pin pitches of radius, "
        f"{large} % above; pin-affine is within 5 % where pins are seen"
    )


@dataclass(frozen=True, eq=False)
class Followed:
    """A region in T frames.

    frames : (T,) indices of those that were not left out. steps : (T-1,) from each to the next. regions : (T,) in each.
    """

    settings: FlowSettings
    frames: tuple[int, ...]
    steps: tuple[FlowStep, ...]
    regions: tuple[Region, ...]

    def rows(self) -> list[dict[str, Any]]:
        """Facts of each step, JSON-ready; ``sum`` is the logarithm of growth since the first frame."""
        sums = itertools.accumulate(step.log_growth for step in self.steps)
        return [
            {
                "from": before, "to": after, "divergence": float(step.divergence),
                "log_growth": float(step.log_growth), "sum": float(total), "used": int(step.n),
            }
            for (before, after), step, total in zip(itertools.pairwise(self.frames), self.steps, sums, strict=True)
        ]  # fmt: skip


def follow_region(
    sequence: FrameSequence,
    settings: FlowSettings,
    ends: tuple[int, int] | None = None,
    region: Region | None = None,
    say: Callable[[str], object] = str,
) -> Followed:
    """Follow a region; a frame in which the pins cannot be told is left out.

    ends : first and last frame, which may run backwards; None: all. region : in the first frame; None: a circle about
    the middle of the pins, half as wide as they reach. say : hears what a reader should know, as soon as it is found.

    FramesError : a frame that is not there. SettingError : a region outside the image, or with fewer than three pins.
    PinsError : too few pins, or three bad frames in a row.
    """
    first, last = ends or (0, len(sequence) - 1)
    if max(first, last) >= len(sequence):
        raise FramesError(
            sequence.name, wanted=f"frames from 0 to {len(sequence) - 1}", found=f"{first},{last}",
            do="Frames are counted from 0.",
        )  # fmt: skip
    region = _region(sequence[first], region, settings, say)
    tracker = FlowTracker(settings)
    tracker.start(sequence[first], region)
    forward = 1 if last > first else -1
    good, steps, n_bad = [first], [], 0
    for after in range(first + forward, last + forward, forward):
        image = sequence[after]
        with said_of(f"{sequence.name}, frame {after}"):
            try:
                steps.append(tracker.step(image))
            except PinsError as trouble:
                n_bad += 1
                if n_bad > MOST_BAD_FRAMES or (after == last and not steps):
                    raise
                say(f"frame {after} is left out: {trouble}")
                continue
        n_bad = 0
        good.append(after)
    for note in notes_by_frame(good[1:], steps):
        say(note)
    return Followed(settings, tuple(good), tuple(steps), (region, *(step.region for step in steps)))


def _region(image: Any, asked: Region | None, settings: FlowSettings, say: Callable[[str], object]) -> Region:
    if asked is not None and settings.engine != "pin-affine":
        return asked
    pins_px = detect_pins(image, settings.pins).centroids_px
    for doubt in pins_in_doubt(pins_px, settings.pins.expect_pins):
        say(doubt)
    if asked is not None:
        need_pins_inside(asked, pins_px)
        return asked
    centre = (pins_px.min(axis=0) + pins_px.max(axis=0)) / 2
    return Region.circle(float(centre[0]), float(centre[1]), float(np.hypot(*(pins_px - centre).T).max()) / 2)
