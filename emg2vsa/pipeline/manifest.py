"""Files that a step wrote outside the store (pages, reports): is what it wrote still there?

Their paths are kept relative to the manifest: the copy of a project speaks of its own files, never of the original's.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from pathlib import Path

from emg2vsa.atomic import write_text_atomic


def write_manifest(path: Path, files: Sequence[Path]) -> None:
    """Remember the files a step wrote outside the store, and their sizes; remove what only its earlier runs wrote."""
    left = {file for earlier in path.parent.glob("*.result") for file in manifest_files(earlier)} - set(files)
    for file in left:
        file.unlink(missing_ok=True)
    sizes = {os.path.relpath(file, path.parent): file.stat().st_size for file in files}
    write_text_atomic(path, json.dumps(sizes))


def manifest_holds(path: Path) -> bool:
    """Whether all files of a manifest are still there, as long as they were."""
    try:
        sizes: Mapping[str, int] = json.loads(path.read_text())
        return all((path.parent / file).stat().st_size == size for file, size in sizes.items())
    except (OSError, ValueError):
        return False


def manifest_files(path: Path) -> list[Path]:
    """The files that a step wrote."""
    return [Path(os.path.abspath(path.parent / file)) for file in json.loads(path.read_text())]
