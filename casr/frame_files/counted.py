"""Frames of a press that were decoded, counted: each once, and apart from that how often one was decoded again."""

from __future__ import annotations

from casr.counts import count
from casr.frame_files.folder import FileFrames
from casr.images import Grey


class CountedFrames:
    """Frames of files, the same to those who read them. The first is looked at when they are opened, and kept."""

    def __init__(self, frames: FileFrames) -> None:
        self.name, self.notes, self.shape, self._frames = frames.name, frames.notes, frames.shape, frames
        self._decoded = bytearray(len(frames))
        count("frames in folder", len(frames))
        self.first = self._decode(0)

    def __len__(self) -> int:
        return len(self._frames)

    def read(self, index: int) -> Grey:
        return self._decode(index) if index else self.first.copy()

    def _decode(self, index: int) -> Grey:
        frame = self._frames.read(index)
        count("frames decoded again" if self._decoded[index] else "frames decoded")
        self._decoded[index] = True
        return frame
