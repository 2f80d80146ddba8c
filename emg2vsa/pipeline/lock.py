"""Who may write to the results of a study: one whole run, or several shards of it.

A whole run holds a lock that ends with its process, however that ends, and a presence for shards on other computers to
see. Each shard holds a presence. A whole run that begins lets the shards end that are there, and keeps others out.
"""

from __future__ import annotations

import contextlib
import json
import os
import time
from collections.abc import Callable, Iterator
from pathlib import Path

from emg2vsa.errors import DataError
from emg2vsa.held_lock import myself, taken, told
from emg2vsa.pipeline.presence import Present, not_a_folder, presence, present
from emg2vsa.pipeline.shard import Shard

_LOOK_AGAIN_S = 0.05
_PATIENCE = 3
"""Looks before anybody is told: ``holder`` takes the lock for a moment."""
LOCK_FILE = ".lock"
WHOLE_FILE = ".lock.whole"


@contextlib.contextmanager
def study_lock(folder: Path, *, wait: bool, say: Callable[[str], None]) -> Iterator[None]:
    """Hold the lock of the results in ``folder``.

    wait : until other holders end, which ``say`` is told once; else DataError says who holds it since when.
    """
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / LOCK_FILE
    not_a_folder(path)
    handle = os.open(path, os.O_RDWR | os.O_CREAT, 0o644)
    try:
        _until_free(folder, lambda: "" if taken(handle) else told(path), wait, say)
        os.ftruncate(handle, 0)
        os.lseek(handle, 0, os.SEEK_SET)
        os.write(handle, json.dumps(myself()).encode())
        with presence(folder / WHOLE_FILE, take_over=True):
            _until_free(folder, lambda: _shards(folder), wait, say)
            yield
    finally:
        os.close(handle)  # gives the lock back


@contextlib.contextmanager
def shard_lock(folder: Path, shard: Shard, *, wait: bool, say: Callable[[str], None]) -> Iterator[None]:
    """Hold the results in ``folder`` for one shard, together with the other shards of the same number.

    wait : until a whole run ends. DataError : another process is this shard, or shards of another number are at work.
    """
    whole = folder / WHOLE_FILE
    while True:
        with _one_of(folder, shard):
            others = [path for path in _presences(folder) if not path.name.endswith(f"-of-{shard.of}")]
            if other := next((f"{_words(path)}, {who}" for path in others if (who := present(path))), ""):
                do = "Wait until it ends, or use the same number of shards."
                raise DataError(folder, wanted=f"shards of {shard.of} only", found=other, do=do)
            if not present(whole):
                yield
                return
        # a whole run is let in first: the two look for each other after they have shown themselves
        _until_free(folder, lambda: present(whole), wait, say)


@contextlib.contextmanager
def _one_of(folder: Path, shard: Shard) -> Iterator[None]:
    """Be the one process that is this shard."""
    try:
        with presence(folder / f"{LOCK_FILE}.{shard.name}"):
            yield
    except Present as error:
        wanted = f"no other process with shard {shard.number} of {shard.of}"
        raise DataError(folder, wanted=wanted, found=error.found, do="Start each shard once.") from None


def holder(folder: Path) -> str:
    """Who holds the lock, in words; "" where nobody does. Changes nothing."""
    path = folder / LOCK_FILE
    try:
        handle = os.open(path, os.O_RDWR)
    except OSError:
        return present(folder / WHOLE_FILE) or _shards(folder)
    try:
        return told(path) if not taken(handle) else present(folder / WHOLE_FILE) or _shards(folder)
    finally:
        os.close(handle)


def _until_free(folder: Path, look: Callable[[], str], wait: bool, say: Callable[[str], None]) -> None:
    looks = 0
    while who := look():
        looks += 1
        if looks > _PATIENCE and not wait:
            do = "Wait until it ends, or run again without --no-wait."
            raise DataError(
                folder, wanted="results that no other run is writing", found=f"results in use by {who}", do=do
            )
        if looks == _PATIENCE + 1:
            say(f"Waiting: another run holds {folder}: {who}.")
        time.sleep(_LOOK_AGAIN_S)


def _presences(folder: Path) -> list[Path]:
    return sorted(folder.glob(f"{LOCK_FILE}.shard-*"))


def _shards(folder: Path) -> str:
    """The first shard at work, in words."""
    return next((f"{_words(path)}, {who}" for path in _presences(folder) if (who := present(path))), "")


def _words(path: Path) -> str:
    return path.name.removeprefix(f"{LOCK_FILE}.").replace("-", " ")
