"""How the readers say that a file, or one frame of it, cannot be read."""

from __future__ import annotations

from pathlib import Path

from casr.errors import FramesError


def unreadable(path: Path, error: OSError) -> FramesError:
    """The operating system refuses the path."""
    advice = {
        FileNotFoundError: "Check the path.",
        PermissionError: "Give yourself the right to read it.",
    }
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


def other_size(path: Path, index: int, shape: tuple[int, ...], wanted: tuple[int, int]) -> FramesError:
    """One frame differs in size from the first."""
    return FramesError(
        f"{path}, frame {index}", wanted=f"{wanted[1]} x {wanted[0]} px like frame 0",
        found=f"{shape[1]} x {shape[0]} px", do="Keep only the frames of one recording together.",
    )  # fmt: skip
