"""Who may write to the results of a study: one run at a time. Its lock ends with its process, however that ends."""

from __future__ import annotations

import contextlib
import json
import os
import time
from collections.abc import Callable, Iterator
from pathlib import Path

from emg2vsa.errors import DataError
from emg2vsa.held_lock import myself, taken, told

_LOOK_AGAIN_S = 0.05
_PATIENCE = 3
"""Looks before anybody is told: ``holder`` takes the lock for a moment."""
LOCK_FILE = ".lock"


@contextlib.contextmanager
def study_lock(folder: Path, *, wait: bool, say: Callable[[str], None]) -> Iterator[None]:
    """Hold the lock of the results in ``folder``.

    wait : until another holder ends, which ``say`` is told once; else DataError says who holds it since when.
    """
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / LOCK_FILE
    if path.is_dir():
        raise DataError(path, wanted="a file, which says who works here", found="a folder", do="Remove it.")
    handle = os.open(path, os.O_RDWR | os.O_CREAT, 0o644)
    try:
        looks = 0
        while not taken(handle):
            looks += 1
            if looks > _PATIENCE and not wait:
                found, do = f"results in use by {told(path)}", "Wait until it ends, or run again without --no-wait."
                raise DataError(folder, wanted="results that no other run is writing", found=found, do=do)
            if looks == _PATIENCE + 1:
                say(f"Waiting: another run holds {folder}: {told(path)}.")
            time.sleep(_LOOK_AGAIN_S)
        os.ftruncate(handle, 0)
        os.lseek(handle, 0, os.SEEK_SET)
        os.write(handle, json.dumps(myself()).encode())
        yield
    finally:
        os.close(handle)  # gives the lock back


def holder(folder: Path) -> str:
    """Who holds the lock, in words; "" where nobody does. Changes nothing."""
    path = folder / LOCK_FILE
    try:
        handle = os.open(path, os.O_RDWR)
    except OSError:
        return ""
    try:
        return "" if taken(handle) else told(path)
    finally:
        os.close(handle)
