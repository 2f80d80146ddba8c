"""Peak memory of one call, in a process of its own."""

from __future__ import annotations

import ctypes
import os
import re
import sys
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

CLEAR, STATUS = Path("/proc/self/clear_refs"), Path("/proc/self/status")
HOW = "Memory is the peak of resident pages during one call less those before it, in a forked process (Linux)."


def peak_mb(run: Callable[[], Any]) -> float | None:
    """Megabytes that one call adds at most to those the process holds; None where the system cannot say.

    The call runs in a fork, so inputs and libraries are loaded and not counted, and its writes are lost.
    """
    if sys.platform != "linux":
        return None
    read_end, write_end = os.pipe()
    pid = os.fork()
    if pid == 0:
        try:
            os.write(write_end, repr(_added_kb(run) / 1024).encode())
        finally:
            os._exit(0)
    os.close(write_end)
    with os.fdopen(read_end) as answer:
        text = answer.read()
    os.waitpid(pid, 0)
    return float(text) if text else None


def _added_kb(run: Callable[[], Any]) -> int:
    _give_back()
    CLEAR.write_text("5")  # the peak becomes what is held now
    before = _peak_kb()
    output = run()
    after = _peak_kb()
    del output
    return after - before


def _give_back() -> None:
    """Give memory that is held but free back to the system: taken again, it would not be seen."""
    with suppress(AttributeError, OSError):  # another library of C than GNU's
        ctypes.CDLL("libc.so.6").malloc_trim(0)


def _peak_kb() -> int:
    found = re.search(r"VmHWM:\s+(\d+) kB", STATUS.read_text())
    assert found
    return int(found.group(1))
