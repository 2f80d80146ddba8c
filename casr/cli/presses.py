"""Which presses a path holds: one, or many in folders of any depth."""

from __future__ import annotations

import re
from pathlib import Path

from casr.errors import FramesError

IMAGES = (".png",)
FILES = (".tif", ".tiff", ".avi", ".npy")


def presses(path: Path) -> list[Path]:
    """The presses at ``path``, in natural order: itself, or those in its folders.

    Raises
    ------
    FramesError : the path is absent, or a folder without frames.
    """
    if not path.exists():
        raise FramesError(path, wanted="frames", found="nothing by that name", do="Check the path.")
    if path.is_file() or _is_press(path):
        return [path]
    found = _inside(path)
    if not found:
        raise FramesError(
            path,
            wanted="frames: PNG, TIFF, AVI or .npy, or folders with them",
            found="none",
            do="Name the folder that holds the frames.",
        )
    return found


def names(found: list[Path], root: Path) -> list[str]:
    """What to call each press: its path below ``root`` with dashes, without a file's suffix."""
    if found == [root]:
        return [root.stem if root.is_file() else root.resolve().name]
    return ["-".join(path.relative_to(root).with_suffix("" if path.is_file() else path.suffix).parts) for path in found]


def _inside(folder: Path) -> list[Path]:
    found: list[Path] = []
    for child in sorted(folder.iterdir(), key=_natural):
        if child.name.startswith("."):
            continue
        if child.is_dir():
            found += [child] if _is_press(child) else _inside(child)
        elif child.suffix.lower() in FILES:
            found.append(child)
    return found


def _is_press(folder: Path) -> bool:
    """Images of its own, or frames by their fixed name."""
    return any(
        child.suffix.lower() in IMAGES or child.stem == "frames" for child in folder.iterdir() if child.name[0] != "."
    )


def _natural(path: Path) -> list[tuple[int, str]]:
    return [(int(part), "") if part.isdigit() else (-1, part.lower()) for part in re.split(r"(\d+)", path.name)]
