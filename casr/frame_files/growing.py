"""A press that is being recorded: its frames and their forces as they come onto the disk."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from casr.camera import Camera
from casr.errors import FramesError
from casr.frame_files.camera_file import read_camera
from casr.frame_files.folder import FORCE_FILE, FileFrames, open_file, open_folder
from casr.frame_files.force_log import ForceLog, read_force_log, read_growing_log
from casr.frame_files.press import camera_beside
from casr.frames import check_newtons, force_per_frame, spikes
from casr.frames.force import first_of_frame
from casr.images import Grey

_LOOK_S = 0.02


@dataclass(frozen=True, eq=False)
class NewFrame:
    """A frame with its force.

    index : from 0. image : (H, W) grey levels. time_s : when it was taken, s on the clock of the log; NaN where the log
    does not tell. force_n : N; NaN where none is known.
    """

    index: int
    image: Grey
    time_s: float
    force_n: float


class GrowingPress:
    """Reads a press while somebody writes it; at its end frames and forces are those of `open_frames`.

    A frame is complete when the force log has a row with the index of the one after it: what belongs to its force has
    come then.

    path : of `open_frames`; what it names need not be there yet.
    force : force log; None for ``force.csv`` in the folder. camera : camera file; None for that beside the press.
    column, force_rule : of `open_frames`. lag_s : frames were taken so long before their times.
    """

    def __init__(
        self,
        path: Path,
        *,
        force: Path | None = None,
        camera: Path | None = None,
        column: str = "force_n",
        force_rule: str = "exposure",
        lag_s: float = 0.0,
    ) -> None:
        self.path, self._force = path, force or path / FORCE_FILE
        self._camera, self._column, self._rule, self._lag_s = camera, column, force_rule, lag_s
        self._frames: FileFrames | None = None
        self._log_bytes = self._next = 0
        self.behind = False
        "The log names a frame that is not there yet: its file may be half written."

    def camera(self) -> Camera | None:
        """The camera of the press, once its frames are there. CameraError as `read_camera`."""
        found = self._camera or (camera_beside(self.path) if self.path.is_dir() else None)
        return None if found is None else read_camera(found)

    def new_frames(self, *, ended: bool = False) -> Iterator[NewFrame]:
        """Frames that are complete since the last call, oldest first. ended : nothing more comes, so all are.

        FramesError : a log or frames that make no sense, or none where nothing more comes.
        """
        log = self._new_log(ended)
        if log is None:
            return
        n_frames = int(log.frame_index.max(initial=-1)) + 1
        forces, times_s = self._forces(log, n_frames)
        for index in range(self._next, n_frames if ended else n_frames - 1):
            image = self._image(index, ended)
            if image is None:
                return
            self._next = index + 1
            yield NewFrame(index, image, float(times_s[index]), float(forces[index]))

    def follow(self, idle_s: float, waiting: Callable[[], None]) -> Iterator[NewFrame]:
        """Frames as they come, until after the first frame or the force of one nothing new has come for ``idle_s``, s.

        waiting : called once where nothing is there yet. Raises as ``new_frames``.
        """
        newest_s, told = None, False
        while newest_s is None or time.monotonic() - newest_s <= idle_s:
            for frame in self.new_frames():
                newest_s = time.monotonic()
                yield frame
            if newest_s is None and not told:
                waiting()
                told = True
            if newest_s is None and self.behind:
                newest_s = time.monotonic()
            time.sleep(_LOOK_S)
        yield from self.new_frames(ended=True)

    def _new_log(self, ended: bool) -> ForceLog | None:
        try:
            size_bytes = self._force.stat().st_size
        except FileNotFoundError:
            size_bytes = 0
            if ended:
                raise FramesError(
                    self._force, wanted="the force log of the press", found="no such file",
                    do="Give the folder that is recorded into, or --force FILE.",
                ) from None  # fmt: skip
        if size_bytes == self._log_bytes and not (ended or self.behind):
            return None
        self._log_bytes = size_bytes
        if ended:
            return read_force_log(self._force, column=self._column)
        return read_growing_log(self._force, column=self._column) if size_bytes else None

    def _forces(self, log: ForceLog, n_frames: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        times_s = np.full(n_frames, np.nan)
        moved = log.frame_time_s
        if moved is not None:
            moved = moved - self._lag_s
            times_s = first_of_frame(log.frame_index, n_frames, moved)
        force_n = np.where(spikes(log.force_n), np.nan, log.force_n)
        check_newtons(force_n, self._force)
        forces = force_per_frame(
            force_n, log.frame_index, n_frames, time_s=log.time_s, frame_time_s=moved, rule=self._rule,
            where=self._force,
        )  # fmt: skip
        return forces, times_s

    def _image(self, index: int, ended: bool) -> Grey | None:
        """None for a frame that is still being written."""
        try:
            if self._frames is None or index >= len(self._frames):
                self._frames = open_folder(self.path) if self.path.is_dir() else open_file(self.path)
            if index >= len(self._frames):
                raise FramesError(
                    self.path, wanted=f"frame {index}, which {self._force.name} names",
                    found=f"{len(self._frames)} frames",
                    do="Give the frames that this log belongs to; frames are counted from 0.",
                )  # fmt: skip
            image = self._frames.read(index)
        except FramesError:
            self._frames, self.behind = None, True
            if ended:
                raise
            return None
        self.behind = False
        return image
