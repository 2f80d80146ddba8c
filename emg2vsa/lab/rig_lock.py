"""One process at a time uses a rig; its lock names it for whoever must end it, and goes with it however it ends."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from emg2vsa.errors import DeviceError
from emg2vsa.held_lock import taken
from emg2vsa.rig.executor.stop_requests import request_stop
from emg2vsa.rig.record.new_folder import how_ended
from emg2vsa.study import plates_beside

SILENT_S = 1.0
"""A process that is asked to stop and does nothing for so long is ended."""
_CLOSING_S = 5.0
"""Longest time from the end of a run until its devices are closed."""
_LOOK_S = 0.02
_GOING = (None, "killed")
"""What ended.json says of a run that goes on."""
_END = getattr(signal, "SIGKILL", signal.SIGTERM)


@dataclass(frozen=True)
class RigUser:
    """The process that holds a rig. folder : of its run; None for moves by hand."""

    pid: int
    folder: Path | None


def lock_path(rig_file: Path) -> Path:
    """Beside the rig file, whatever link leads to it."""
    rig_file = rig_file.resolve()
    return rig_file.with_name(f".{rig_file.stem}.lock")


@contextlib.contextmanager
def rig_lock(rig_file: Path, folder: Path | None = None) -> Iterator[None]:
    """Hold the rig of a file. DeviceError, with the other's process id, where another process holds it."""
    path = lock_path(rig_file)
    handle = os.open(path, os.O_RDWR | os.O_CREAT, 0o644)
    try:
        if not taken(handle):
            other = rig_user(rig_file)
            found = f"process {other.pid}" if other else "another process"
            do = f"Wait until it ends, or end it: emg2vsa rig off {rig_file}."
            raise DeviceError(rig_file, wanted="a rig that no other process uses", found=found, do=do)
        user = {"pid": os.getpid(), "folder": str(folder.absolute()) if folder else None}
        os.ftruncate(handle, 0)
        os.lseek(handle, 0, os.SEEK_SET)
        os.write(handle, json.dumps(user).encode())
        yield
    finally:
        os.close(handle)


def rig_user(rig_file: Path) -> RigUser | None:
    """The process that holds the rig at this moment."""
    try:
        handle = os.open(lock_path(rig_file), os.O_RDWR)
    except OSError:
        return None
    try:
        if taken(handle):
            return None
        held = json.loads(os.read(handle, 4096))
        return RigUser(int(held["pid"]), Path(held["folder"]) if held["folder"] else None)
    except (OSError, ValueError, KeyError, TypeError):
        return None  # just being written
    finally:
        os.close(handle)


def end_user(rig_file: Path, say: Callable[[str], None]) -> None:
    """End the process that uses the rig, if any: asked first, and ended by its id when it is silent for 1 s.

    A run is asked by its file ``stop``, and is silent when its log does not grow; a move by hand by SIGTERM.

    DeviceError : the process belongs to somebody else.
    """
    user = rig_user(rig_file)
    if user is None:
        return
    say(f"process {user.pid} uses the rig: asked to stop")
    try:
        if user.folder is None:
            os.kill(user.pid, signal.SIGTERM)
        else:
            request_stop(user.folder, "emg2vsa rig off")
        if not _falls_silent(user, lambda: rig_user(rig_file) == user, _CLOSING_S):
            say(f"process {user.pid} has ended by itself")
            return
        say(f"process {user.pid} is silent: ended")
        os.kill(user.pid, _END)
    except ProcessLookupError:
        return
    except PermissionError as error:
        do = "Ask its owner, or the administrator; else switch the power off."
        raise DeviceError(
            f"process {user.pid}", wanted="a process of yours", found="a process of another user", do=do
        ) from error
    until_s = time.monotonic() + _CLOSING_S
    while rig_user(rig_file) == user and time.monotonic() < until_s:
        time.sleep(_LOOK_S)


def stop_unnamed_run(runs: Path, say: Callable[[str], None]) -> None:
    """Ask the run to stop whose lock was deleted or spoilt: the newest in ``runs``, or of its plates, that has not
    ended and whose log has just grown. Nobody knows its process: one that is silent is left."""
    logs = [log for root in (runs, plates_beside(runs)) for log in root.glob("*/log.csv")]
    going = [log for log in logs if how_ended(log.parent) in _GOING and time.time() - log.stat().st_mtime < _CLOSING_S]
    if going:
        folder = max(going, key=lambda log: log.stat().st_mtime).parent
        say(f"{folder} has not ended, though the rig's lock names no run: asked to stop")
        request_stop(folder, "emg2vsa rig off")
        _falls_silent(RigUser(0, folder), lambda: True, SILENT_S)


def _falls_silent(user: RigUser, there: Callable[[], bool], closing_s: float) -> bool:
    """Wait while it is there and gives signs of life; whether it stays without any. closing_s : after a run's end."""
    last, seen_s = _signs(user), time.monotonic()
    while there():
        if (now := _signs(user)) != last:
            last, seen_s = now, time.monotonic()
        if time.monotonic() - seen_s > (SILENT_S if last[1] in _GOING else closing_s):
            return True
        time.sleep(_LOOK_S)
    return False


def _signs(user: RigUser) -> tuple[int, str | None]:
    """What a living run changes: the length of its log, and how it ended."""
    if user.folder is None:
        return 0, None
    try:
        return (user.folder / "log.csv").stat().st_size, how_ended(user.folder)
    except OSError:
        return 0, how_ended(user.folder)
