"""A file that one process at a time holds, and that names its holder; its lock ends with the process."""

from __future__ import annotations

import json
import os
import sys
from datetime import datetime
from pathlib import Path

_BYTE = 1 << 30
"""Windows locks a byte, which nobody else may read then: one far behind the text that names the holder."""


def myself() -> dict[str, object]:
    """Who holds a claim or a lock: process, computer, and since when."""
    return {
        "pid": os.getpid(),
        "host": _computer(),
        "since": datetime.now().astimezone().isoformat("T", "seconds"),
    }


def _computer() -> str:
    """Name of this computer, as ``platform.node`` tells it, which loads much."""
    return os.uname().nodename if hasattr(os, "uname") else os.environ.get("COMPUTERNAME", "")


def told(path: Path) -> str:
    """The holder that a claim or a lock names, in words."""
    try:
        held = json.loads(path.read_text())
        since = datetime.fromisoformat(held["since"]).strftime("%H:%M:%S on %Y-%m-%d")
        return f"process {held['pid']} on {held['host']}, since {since}"
    except (OSError, ValueError, KeyError, TypeError):
        return "another process"


if sys.platform == "win32":
    import msvcrt

    def taken(handle: int) -> bool:
        """Take the lock of an open file, unless another process holds it; closing the file gives it back."""
        os.lseek(handle, _BYTE, os.SEEK_SET)
        try:
            msvcrt.locking(handle, msvcrt.LK_NBLCK, 1)
        except OSError:
            return False
        return True

else:
    import fcntl

    def taken(handle: int) -> bool:
        """Take the lock of an open file, unless another process holds it; closing the file gives it back."""
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            return False
        return True
