"""One press on disk as it happens: frames.tif and force.csv, as `casr.frame_files.open_frames` reads them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from emg2vsa.durable.append_file import AppendFile
from emg2vsa.durable.writer import AT_ONCE, Writer
from emg2vsa.rig.record.tiff_pages import TiffPages


class PressRecorder:
    """Writes a press; readable at any moment, also after the program was killed.

    A frame is on disk before the first force row that carries its index.

    Parameters
    ----------
    folder : made when missing; must hold no press.
    shape : (height, width) of the frames, px.

    Raises
    ------
    DeviceError : there is a press already, or no place to write.
    """

    def __init__(self, folder: Path, shape: tuple[int, int], writer: Writer = AT_ONCE) -> None:
        self._force = AppendFile(folder / "force.csv", writer)
        self._force.append(b"time_s,force_n,frame_index,frame_time_s\n")
        self._frame_time = ""
        self._frames = TiffPages(folder / "frames.tif", shape, writer)

    @property
    def n_frames(self) -> int:
        """Frames saved."""
        return self._frames.n_pages

    def frame(self, image: NDArray[np.uint8], time_s: float) -> int:
        """Save a frame taken then; its index, from 0. Raises DeviceError, as `force`, when the disk is full."""
        self._frames.append(image)
        self._frame_time = f"{time_s:.6f}"
        return self.n_frames - 1

    def force(self, time_s: float, force_n: float) -> None:
        """Save the force of a time with index and time of the last frame saved, -1 and none before the first."""
        self._force.append(f"{time_s:.6f},{force_n:.6f},{self.n_frames - 1},{self._frame_time}\n".encode())

    def remark(self, text: str) -> None:
        """A comment at the end of the forces, which goes with the press wherever it is taken."""
        self._force.append(f"# {text}\n".encode())

    def close(self) -> None:
        """Give the files back."""
        self._frames.close()
        self._force.close()
