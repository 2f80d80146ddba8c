"""Files that say who works at a study, for processes of all computers that share its folder.

A presence appears whole, by a hard link, which one process alone can make, on network file systems too. It goes when
its holder ends. The system tells whether a holder on this computer still runs. Of a holder on another computer it
cannot tell, so that presence stays until somebody removes the file.
"""

from __future__ import annotations

import contextlib
import json
import os
import platform
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

from emg2vsa.errors import DataError
from emg2vsa.held_lock import myself, taken, told

_TRIES, _AGAIN_S = 20, 0.01


class Present(DataError):
    """Another process holds the presence; ``found`` says which."""


@contextlib.contextmanager
def presence(path: Path, *, take_over: bool = False) -> Iterator[None]:
    """Hold the presence ``path``.

    take_over : the caller knows that whoever is named there has ended, on another computer too.

    Raises
    ------
    Present : another process holds it. DataError : the file system has no hard links.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    handle, name = tempfile.mkstemp(dir=path.parent, prefix=".taking.")
    left = [Path(name)]
    try:
        os.write(handle, json.dumps(myself()).encode())
        os.chmod(name, 0o644)
        taken(handle)
        _link(Path(name), path, take_over)
        left = _removed(Path(name))
        try:
            yield
        finally:
            left += _removed(path)
    finally:
        os.close(handle)
        for each in left:
            each.unlink(missing_ok=True)


def present(path: Path) -> str:
    """Who holds the presence, in words; "" where nobody does, or where its holder on this computer has ended.

    DataError : a folder is in its place.
    """
    not_a_folder(path)
    try:
        handle = os.open(path, os.O_RDWR)
    except FileNotFoundError:
        return ""
    except OSError as error:
        return f"another process ({path}: {error.strerror})"
    try:
        if not taken(handle):
            return told(path)
        return "" if _is_here(handle) else f"{told(path)}, {_age(path)} ago (if it has ended, remove {path})"
    finally:
        os.close(handle)


def not_a_folder(path: Path) -> None:
    """DataError where a folder is in the place of a lock."""
    if path.is_dir():
        raise DataError(path, wanted="a file, which says who works here", found="a folder", do="Remove it.")


def _link(own: Path, path: Path, take_over: bool) -> None:
    who = ""
    for _ in range(_TRIES):
        try:
            os.link(own, path)
            return
        except FileExistsError:
            who = present(path)
            # else look again: who looks at the presence of one that has ended holds it briefly
            if take_over or not who:
                _remove_left(path, take_over)
            time.sleep(_AGAIN_S)
        except OSError as error:
            do = "Put the results on a file system that has hard links."
            found = error.strerror or str(error)
            raise DataError(path, wanted="a file system with hard links", found=found, do=do) from error
    raise Present(path, wanted="a name that no process holds", found=who or "others", do="Wait until they end.")


def _remove_left(path: Path, whosever: bool) -> None:
    """Remove a presence that its holder left; its lock sees to it that no newer one goes."""
    with contextlib.suppress(FileNotFoundError):
        handle, left = os.open(path, os.O_RDWR), []
        try:
            if taken(handle) and os.path.samestat(os.fstat(handle), os.stat(path)) and (whosever or _is_here(handle)):
                left = _removed(path)
        finally:
            os.close(handle)
        for each in left:
            each.unlink(missing_ok=True)


def _is_here(handle: int) -> bool:
    """Whether the holder that an open presence names ran on this computer."""
    os.lseek(handle, 0, os.SEEK_SET)
    try:
        return bool(json.loads(os.read(handle, 4096))["host"] == platform.node())
    except (ValueError, KeyError, TypeError):
        return False


def _age(path: Path) -> str:
    """How long the presence has been there, by the clock of the file system alone."""
    try:
        with tempfile.TemporaryFile(dir=path.parent) as now:
            minutes = (os.fstat(now.fileno()).st_mtime - path.stat().st_mtime) / 60
    except OSError:
        return "an unknown time"
    return f"{minutes:.0f} min" if minutes < 120 else f"{minutes / 60:.0f} h"


def _removed(path: Path) -> list[Path]:
    """Remove a file that may be open; on Windows, which removes no open file, it is left to be removed later."""
    try:
        path.unlink(missing_ok=True)
    except PermissionError:
        return [path]
    return []
