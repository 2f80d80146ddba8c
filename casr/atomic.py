"""Files written whole or not at all."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterable
from pathlib import Path


def write_bytes_atomic(path: Path, data: bytes) -> None:
    """Write ``data`` so that a reader sees the old file or the new one, never a part; folders are made.

    OSError : names ``path``, also where the disk is full.
    """
    _write_atomic(path, (data,))


def write_text_atomic(path: Path, text: str | Iterable[str]) -> None:
    """``write_bytes_atomic`` for UTF-8 text, newlines as given. text : or its pieces, written one by one."""
    _write_atomic(path, (piece.encode() for piece in ((text,) if isinstance(text, str) else text)))


def _write_atomic(path: Path, pieces: Iterable[bytes]) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    try:
        with os.fdopen(handle, "wb") as file:
            for piece in pieces:
                file.write(piece)
        os.chmod(temporary, 0o644)
        os.replace(temporary, path)
    except BaseException as error:
        Path(temporary).unlink(missing_ok=True)
        if isinstance(error, OSError) and error.errno is not None and error.filename is None:
            error.filename = str(path)
        raise
