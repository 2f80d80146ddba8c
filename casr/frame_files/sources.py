"""Which module reads which file. Each is imported when such a file is opened: tifffile alone takes 30 ms."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import Protocol

from casr.errors import FramesError
from casr.frame_files.trouble import check_exists
from casr.frames import FrameSource

# suffix -> module with open_file(path) -> FileFrames
SOURCES = {
    ".tif": "casr.frame_files.tiff",
    ".tiff": "casr.frame_files.tiff",
    ".avi": "casr.frame_files.video",
    ".mp4": "casr.frame_files.video",
    ".mkv": "casr.frame_files.video",
    ".npy": "casr.frame_files.npy",
}


class FileFrames(FrameSource, Protocol):
    """Frames from a file, with what is to be said about the file."""

    notes: tuple[str, ...]


def open_file(path: Path) -> FileFrames:
    """The frames of one file. Raises FramesError when there is none or its suffix is not in the table."""
    check_exists(path)
    module = SOURCES.get(path.suffix.lower())
    if module is None:
        raise FramesError(
            path,
            wanted=f"a folder of images or a file ending in {', '.join(SOURCES)}",
            found=f"a file ending in {path.suffix or 'nothing'}",
            do="Give the folder that holds the frames, or save them in one of these formats.",
        )
    frames: FileFrames = import_module(module).open_file(path)
    return frames
