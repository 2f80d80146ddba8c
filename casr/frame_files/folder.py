"""What a folder holds: the frames of one press, or presses in folders and files of their own."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

import cv2

from casr.errors import FramesError
from casr.frame_files.natural_order import natural_order
from casr.frame_files.pages import PAGE_KINDS, PageFrames
from casr.frame_files.sources import SOURCES, FileFrames, open_file
from casr.frame_files.trouble import unreadable

FORCE_FILE = "force.csv"
CAMERA_FILE = "camera.toml"
FRAMES_FOLDER = "frames"


@dataclass(frozen=True)
class Contents:
    """What a folder holds, hidden entries left out.

    Parameters
    ----------
    pages : files of one frame each.
    stacks : files of many frames each.
    folders : folders below.
    others : everything else.
    """

    pages: list[Path]
    stacks: list[Path]
    folders: list[Path]
    others: list[Path]

    @property
    def frames_folder(self) -> list[Path]:
        return [folder for folder in self.folders if folder.name == FRAMES_FOLDER]


def find_presses(path: Path | str) -> list[Path]:
    """Everything under ``path`` that `open_frames` opens, in natural order: the path itself, or what lies below it.

    Links to folders are not followed. Raises FramesError when there is nothing or it cannot be read.
    """
    path = Path(path)
    presses = _presses_in(path) if path.is_dir() else [path]
    if not path.exists():
        raise unreadable(path, FileNotFoundError(2, "No such file or directory"))
    if not presses:
        raise _no_frames(path)
    return presses


def open_folder(path: Path) -> FileFrames:
    """Frames of a folder that holds one press: image files, one file of frames, or images in a folder ``frames``.

    Raises
    ------
    FramesError : no frames, or more than one candidate.
    """
    contents = folder_contents(path)
    found = [*contents.stacks, *contents.frames_folder, *([path / "images"] if contents.pages else [])]
    if not found:
        raise _no_frames(path)
    if len(found) > 1:
        raise FramesError(
            path,
            wanted="the frames of one press",
            found=f"{len(found)} sequences ({', '.join(item.name for item in found[:3])}{', ...' * (len(found) > 3)})",
            do="Give one of them.",
        )
    if contents.stacks:
        frames = open_file(contents.stacks[0])
        frames.name = path.name
        return frames
    if contents.pages:
        return PageFrames(contents.pages, name=path.name)
    return PageFrames(folder_contents(contents.frames_folder[0]).pages, name=path.name)


def folder_contents(path: Path) -> Contents:
    """Sorts the entries of a folder. Raises FramesError when it cannot be read."""
    try:
        with os.scandir(path) as entries:
            seen = [(Path(entry.path), entry.is_dir()) for entry in entries if not entry.name.startswith(".")]
    except OSError as error:
        raise unreadable(path, error) from error
    files = [item for item, is_folder in seen if not is_folder]
    images = [file for file in files if file.suffix.lower() in PAGE_KINDS]
    many = _are_stacks(images)
    pages = [] if many else images
    stacks = [file for file in files if file.suffix.lower() in SOURCES and file not in set(pages)]
    taken = {*pages, *stacks}
    return Contents(
        pages,
        sorted(stacks, key=natural_order),
        sorted((item for item, is_folder in seen if is_folder), key=natural_order),
        [file for file in files if file not in taken],
    )
