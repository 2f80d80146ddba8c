"""What one step took: CPU and wall seconds, peak memory, and what was counted inside it."""

from __future__ import annotations

import contextlib
import os
import re
import sys
import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from casr.counts import counting

if sys.platform != "win32":
    import resource

_STATUS = Path("/proc/self/status")


@dataclass
class Spent:
    """What a step took in its process.

    cpu_s : CPU seconds of the process and of the child processes that ended meanwhile, all threads. wall_s : seconds
    by the clock. peak_mb : largest resident memory, MB; None where the system does not tell. counts : by the names of
    ``casr.counts.COUNTED``.
    """

    cpu_s: float = 0.0
    wall_s: float = 0.0
    peak_mb: float | None = None
    counts: Mapping[str, int] = field(default_factory=dict)


@contextlib.contextmanager
def measured() -> Iterator[Spent]:
    """What is done inside; the numbers are there when it has ended, by an error too."""
    spent, before_s, since_s = Spent(), _cpu_s(), time.perf_counter()
    _forget_peak()
    with counting() as counts:
        try:
            yield spent
        finally:
            spent.cpu_s, spent.wall_s = _cpu_s() - before_s, time.perf_counter() - since_s
            spent.peak_mb, spent.counts = _peak_mb(), counts


def _cpu_s() -> float:
    ended = os.times()
    return time.process_time() + ended.children_user + ended.children_system


def _forget_peak() -> None:
    """Linux counts the peak anew from here, so that it is the step's and not that of a step before it."""
    if sys.platform == "linux":
        with contextlib.suppress(OSError):
            Path("/proc/self/clear_refs").write_text("5")


def _peak_mb() -> float | None:
    """Since ``_forget_peak`` on Linux; elsewhere since the process began, or not known."""
    if sys.platform == "linux":
        with contextlib.suppress(OSError):
            found = re.search(r"VmHWM:\s+(\d+) kB", _STATUS.read_text())
            return int(found[1]) * 1024 / 1e6 if found else None
    if sys.platform != "win32":
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / (1e6 if sys.platform == "darwin" else 1e3)
    return None
