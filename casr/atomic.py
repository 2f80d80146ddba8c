"""Files written whole or not at all."""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path


def write_bytes_atomic(path: Path, data: bytes, *, on_disk: bool = False, mode: int = 0o644) -> None:
    """Write ``data`` so that a reader sees the old file or the new one, never a part; folders are made.

    on_disk : return when file and name have reached the disk itself, so that a loss of power takes neither.
    mode : of the file. OSError : names ``path``, also where the disk is full.
    """
    _write_atomic(path, (data,), on_disk, mode)


def write_text_atomic(path: Path, text: str | Iterable[str], *, mode: int = 0o644) -> None:
    """``write_bytes_atomic`` for UTF-8 text, newlines as given. text : or its pieces, written one by one."""
    _write_atomic(path, (piece.encode() for piece in ((text,) if isinstance(text, str) else text)), mode=mode)


def write_new(path: Path, data: bytes) -> None:
    """Write ``data`` whole into a new file that has reached the disk itself; of two who try at once one succeeds.

    FileExistsError : the file is there already. OSError : names ``path``.
    """
    import tempfile  # loads much, which a program that writes nothing does without

    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=path.parent, prefix=f".{path.name}.") as folder:
            whole = Path(folder) / "whole"
            write_bytes_atomic(whole, data, on_disk=True)
            _link_or_write(whole, path)
        sync_folder(path.parent)
    except OSError as error:
        error.filename, error.filename2 = str(path), None
        raise


def _link_or_write(whole: Path, path: Path) -> None:
    try:
        os.link(whole, path)
    except FileExistsError:
        raise
    except OSError:  # a file system without hard links
        with path.open("xb") as file:
            file.write(whole.read_bytes())


def sync_folder(folder: Path) -> None:
    """Names of files reach the disk itself; Windows has no such call, and its file systems need none."""
    if hasattr(os, "O_DIRECTORY"):
        handle = os.open(folder, os.O_DIRECTORY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)


def _write_atomic(path: Path, pieces: Iterable[bytes], on_disk: bool = False, mode: int = 0o644) -> None:
    import tempfile

    path.parent.mkdir(parents=True, exist_ok=True)
    handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    try:
        with os.fdopen(handle, "wb") as file:
            for piece in pieces:
                file.write(piece)
            if on_disk:
                file.flush()
                os.fsync(file.fileno())
        os.chmod(temporary, mode)
        os.replace(temporary, path)
        if on_disk:
            sync_folder(path.parent)
    except BaseException as error:
        Path(temporary).unlink(missing_ok=True)
        if isinstance(error, OSError) and error.errno is not None:
            error.filename, error.filename2 = str(path), None
            if path.is_dir():
                error.strerror = "A folder is in place of this file"
        raise
