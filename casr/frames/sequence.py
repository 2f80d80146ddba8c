"""Frames of one press, read one at a time, with the camera that saw them and the force of each."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from casr.camera import Camera
from casr.errors import CameraError, FramesError
from casr.frames.readings import ForceReadings, TravelReadings
from casr.images import Grey


class FrameSource(Protocol):
    """Where frames come from: a file, a folder, an array, a renderer.

    ``shape`` is (height, width) of every frame, px; ``read`` gives one frame as grey levels and keeps no other.
    """

    name: str

    @property
    def shape(self) -> tuple[int, int]: ...

    def __len__(self) -> int: ...

    def read(self, index: int) -> Grey: ...


MOST_KEPT_BYTES = 64 * 2**20
"""Most bytes of decoded frames that are kept: 700 of 300 x 300 px, many times a press; a recording of hours must not
fill the memory.
"""


class KeptFrames:
    """A source that keeps what it has decoded, as far as it fits; frames are read-only."""

    def __init__(self, source: FrameSource) -> None:
        self.name = source.name
        self._source, self._left_bytes = source, MOST_KEPT_BYTES
        self._kept: dict[int, Grey] = {}

    @property
    def shape(self) -> tuple[int, int]:
        return self._source.shape

    def __len__(self) -> int:
        return len(self._source)

    def read(self, index: int) -> Grey:
        if index in self._kept:
            return self._kept[index]
        frame = self._source.read(index)
        if frame.nbytes <= self._left_bytes:
            frame = frame.view()
            frame.flags.writeable = False
            self._kept[index] = frame
            self._left_bytes -= frame.nbytes
        return frame


@dataclass(frozen=True)
class FrameSequence:
    """One press: frames in time order, and what else is known of it.

    source : gives the frames. camera : needed for mm; None leaves everything in px.
    force_n : (T,) force of each frame, N, NaN where it is not known; None without a force log.
    notes : what a reader of results ought to know about these frames.
    readings : the log that ``force_n`` comes from, where it has times; frames and force can be shifted by it.
    mean_force_n : (T,) mean of the log's rows that carry the index of the frame, N, as the paper has it; None without
        a force log.
    travel : how far the indenter had gone; None where the log does not say.
    CameraError : the camera's image size is not that of the frames. FramesError : not one force for each frame.
    """

    source: FrameSource
    camera: Camera | None = None
    force_n: NDArray[np.float64] | None = None
    notes: tuple[str, ...] = ()
    readings: ForceReadings | None = None
    mean_force_n: NDArray[np.float64] | None = None
    travel: TravelReadings | None = None

    def __repr__(self) -> str:
        force = "no force" if self.force_n is None else f"force up to {np.nanmax(self.force_n, initial=-np.inf):.3g} N"
        camera = "no camera" if self.camera is None else "camera known"
        size = f"{self.shape[1]} x {self.shape[0]} px"
        return f"FrameSequence({self.name!r}: {len(self)} frames of {size}, {force}, {camera})"

    def __post_init__(self) -> None:
        height_px, width_px = self.shape
        if self.camera is not None and (self.camera.width_px, self.camera.height_px) != (width_px, height_px):
            raise CameraError(
                self.name, wanted=f"frames of the camera's size, {self.camera.width_px} x {self.camera.height_px} px",
                found=f"frames of {width_px} x {height_px} px",
                do="Give the camera file that belongs to these frames; cropping moves cx_px and cy_px too.",
            )  # fmt: skip
        if self.force_n is not None and self.force_n.shape != (len(self),):
            raise FramesError(
                self.name, wanted=f"one force for each of the {len(self)} frames",
                found=f"an array of shape {self.force_n.shape}",
                do="Average the force rows of each frame first: force_per_frame.",
            )  # fmt: skip

    def by_mean(self) -> FrameSequence:
        """The same frames, with the mean of the log's rows as the force of each. FramesError where none is known."""
        if self.mean_force_n is None:
            raise FramesError(
                self.name, wanted="a force log whose rows carry the index of the frame (force rule mean)",
                found="none" if self.force_n is None else "one force for each frame",
                do="Give the log, or take the force at exposure.",
            )  # fmt: skip
        return replace(self, force_n=self.mean_force_n, readings=None)

    def kept(self) -> FrameSequence:
        """The same frames, of which the first ``MOST_KEPT_BYTES`` that are read are decoded once only."""
        return replace(self, source=KeptFrames(self.source))

    @property
    def name(self) -> str:
        return self.source.name

    @property
    def shape(self) -> tuple[int, int]:
        """(height, width) of every frame, px."""
        return self.source.shape

    def __len__(self) -> int:
        return len(self.source)

    def __getitem__(self, index: int) -> Grey:
        """Frame ``index`` from 0, or from the end when negative. Raises FramesError when there is none."""
        if not -len(self) <= index < len(self):
            raise FramesError(
                self.name, wanted=f"a frame from 0 to {len(self) - 1}", found=f"frame {index}",
                do="Frames are counted from 0 in the order of the file.",
            )  # fmt: skip
        return self.source.read(index % len(self))

    def __iter__(self) -> Iterator[Grey]:
        return (self[index] for index in range(len(self)))
