"""How the readers say that a file, or one frame of it, cannot be read; frames that must be of one size."""

from __future__ import annotations

from abc import ABC, abstractmethod
from pathlib import Path

from casr.errors import FramesError
from casr.images import Grey


def unreadable(path: Path, error: OSError) -> FramesError:
    """The operating system refuses the path."""
    advice = {FileNotFoundError: "Check the path.", PermissionError: "Give yourself the right to read it."}
    return FramesError(
        path, wanted="a file or folder that can be read", found=error.strerror or str(error),
        do=advice.get(type(error), "Check the path and the disk."),
    )  # fmt: skip


def check_exists(path: Path) -> None:
    """Raises FramesError when there is nothing at the path, or no way to it."""
    try:
        path.stat()
    except OSError as error:
        raise unreadable(path, error) from error


def undecodable(path: Path, index: int, found: str) -> FramesError:
    """One frame is damaged; the others stay readable."""
    return FramesError(
        f"{path}, frame {index}", wanted="an image", found=found,
        do="The file is damaged or incomplete there; copy it again or use the frames around it.",
    )  # fmt: skip


class OneSize(ABC):
    """Frames of one size, decoded one at a time when asked for.

    FramesError : the first does not decode; on reading, one that is damaged or has another size than the first.
    """

    name: str
    notes: tuple[str, ...]

    def __init__(self, path: Path, n_frames: int) -> None:
        self._path, self._n = path, n_frames
        self.shape: tuple[int, int] = self._decoded(0).shape

    def __len__(self) -> int:
        return self._n

    @abstractmethod
    def _decoded(self, index: int) -> Grey:
        """One frame, of whatever size it has."""

    def _file(self, index: int) -> Path:
        return self._path

    def read(self, index: int) -> Grey:
        """Frame of this index. FramesError : it is damaged, or has another size than the first."""
        frame = self._decoded(index)
        if frame.shape != self.shape:
            raise FramesError(
                f"{self._file(index)}, frame {index}", wanted=f"{self.shape[1]} x {self.shape[0]} px like frame 0",
                found=f"{frame.shape[1]} x {frame.shape[0]} px", do="Keep only the frames of one recording together.",
            )  # fmt: skip
        return frame
