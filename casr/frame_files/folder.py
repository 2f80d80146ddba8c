"""What a path holds: a file of frames, a folder with the frames of one press, or presses in folders and files of their
own. The module that reads a kind of file is imported when such a file is opened: tifffile alone takes 30 ms."""

from __future__ import annotations

import os
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import cv2

from casr.by_name import module_named
from casr.errors import FramesError
from casr.frame_files.pages import PAGE_KINDS, PageFrames
from casr.frame_files.trouble import check_exists, unreadable
from casr.frames import FrameSource

FORCE_FILE = "force.csv"
CAMERA_FILE = "camera.toml"
FRAMES = "frames"

# suffix -> module with open_file(path) -> FileFrames
SOURCES = {
    ".tif": "casr.frame_files.tiff",
    ".tiff": "casr.frame_files.tiff",
    ".avi": "casr.frame_files.video",
    ".mp4": "casr.frame_files.video",
    ".mkv": "casr.frame_files.video",
    ".npy": "casr.frame_files.pages",
}
_DIGITS = re.compile(r"([0-9]+)")


class FileFrames(FrameSource, Protocol):
    """Frames from a file, with what is to be said about the file."""

    notes: tuple[str, ...]


@dataclass(frozen=True)
class Contents:
    """What a folder holds, each in natural order.

    pages : files of one frame each. stacks : files of many frames each. folders : folders below.
    others : everything else, and whatever is hidden.
    """

    pages: list[Path]
    stacks: list[Path]
    folders: list[Path]
    others: list[Path]


def open_file(path: Path) -> FileFrames:
    """The frames of one file. Raises FramesError when there is none or its suffix is not in the table."""
    check_exists(path)
    module = SOURCES.get(path.suffix.lower())
    if module is None:
        raise FramesError(
            path, wanted=f"a folder of images or a file ending in {', '.join(SOURCES)}",
            found=f"a file ending in {path.suffix or 'nothing'}",
            do="Give the folder that holds the frames, or save them in one of these formats.",
        )  # fmt: skip
    frames: FileFrames = module_named(module).open_file(path)
    return frames


def find_presses(path: Path | str) -> list[Path]:
    """Everything under ``path`` that `open_frames` opens, in natural order: the path itself, or what lies below it.

    Links to folders are not followed. Raises FramesError when there is nothing or it cannot be read.
    """
    path = Path(path)
    check_exists(path)
    presses = _presses_in(path) if path.is_dir() else [path]
    if not presses:
        raise _no_frames(path)
    return presses


def open_folder(path: Path) -> FileFrames:
    """Frames of a folder that holds one press.

    They are the file ``frames`` (.tif, .avi, .npy ...) or the images in a folder ``frames``; without these, the
    images or the one file of frames the folder holds.

    FramesError : no frames, or more than one candidate.
    """
    contents = folder_contents(path)
    sequences = _sequences(contents)
    if not sequences:
        raise _no_frames(path)
    if len(sequences) > 1:
        names = ", ".join(files[0].name for files in sequences[:3])
        raise FramesError(
            path, wanted="the frames of one press",
            found=f"{len(sequences)} sequences ({names}{', ...' * (len(sequences) > 3)})",
            do="Give one of them, or name the right one frames.",
        )  # fmt: skip
    files = sequences[0]
    frames = open_file(files[0]) if files[0] in contents.stacks else PageFrames(files)
    frames.name = path.resolve().name
    return frames


def folder_contents(path: Path) -> Contents:
    """The entries of a folder, sorted out. Raises FramesError when it cannot be read."""
    try:
        with os.scandir(path) as entries:
            seen = {Path(entry.path): entry.is_dir() for entry in entries}
    except OSError as error:
        raise unreadable(path, error) from error
    shown = sorted((item for item in seen if item.name[0] != "."), key=_natural_order)
    files = [item for item in shown if not seen[item]]
    pages = [file for file in files if file.suffix.lower() in PAGE_KINDS]
    tiffs = [file for file in pages if file.suffix.lower() in SOURCES]
    # one format for both: a folder of single pages, or of files with many
    if tiffs and (len(pages) == 1 or cv2.imcount(str(tiffs[0])) > 1):
        pages = [file for file in pages if file not in tiffs]
    taken = set(pages)
    stacks = [file for file in files if file.suffix.lower() in SOURCES and file not in taken]
    taken.update(stacks)
    return Contents(
        pages,
        stacks,
        folders=[item for item in shown if seen[item]],
        others=[item for item in seen if item not in taken and not (seen[item] and item.name[0] != ".")],
    )


def _natural_order(path: Path) -> tuple[list[str | int], str]:
    """Sort key: every run of digits in the name counts as a number, letters without case; equal ones by spelling."""
    parts = _DIGITS.split(path.name.casefold())
    # text and numbers take turns and text comes first, so like meets like
    return [int(part) if place % 2 else part for place, part in enumerate(parts)], path.name


def _sequences(contents: Contents) -> list[list[Path]]:
    """Candidates for the frames of a press: the files of each."""
    named = [[stack] for stack in contents.stacks if stack.stem == FRAMES]
    named += [
        pages for folder in contents.folders if folder.name == FRAMES and (pages := folder_contents(folder).pages)
    ]
    return named or [*([stack] for stack in contents.stacks), *([contents.pages] if contents.pages else [])]


def _presses_in(path: Path) -> list[Path]:
    contents = folder_contents(path)
    if contents.pages or len(_sequences(contents)) == 1:
        return [path]
    below = [press for folder in contents.folders if not folder.is_symlink() for press in _presses_in(folder)]
    return contents.stacks + below


def _no_frames(path: Path) -> FramesError:
    contents = folder_contents(path)
    return FramesError(
        path, wanted=f"images ({', '.join(PAGE_KINDS)}) or a file of frames ({', '.join(SOURCES)})",
        found=f"{len(contents.others)} other files and {len(contents.folders)} folders",
        do="Give the folder that holds the frames of a press.",
    )  # fmt: skip
