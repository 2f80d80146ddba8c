"""A process that keeps time: what a control loop asks of the operating system and of Python (decision 0015)."""

from __future__ import annotations

import gc
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager

LEAST_PRIORITY = 1
"""The lowest of the real-time priorities is above every ordinary program."""
_SWITCH_S = 2e-4
"""A thread that fetches frames, or watches the log, hands the interpreter over after this time instead of 5 ms."""


@contextmanager
def undisturbed() -> Iterator[bool]:
    """For the time of a run: scheduled in real time where the system permits it, True then; threads that give way soon;
    short collections of garbage.

    To be entered before the devices are opened: threads started within are scheduled alike, so that none holds the
    interpreter while an ordinary program has its processor. What is in memory already is left out of the collections
    of garbage; a search of all of it was measured to take 35 ms.
    """
    gc.collect()
    gc.freeze()
    usual_s = sys.getswitchinterval()
    sys.setswitchinterval(_SWITCH_S)
    permitted = _real_time(True)
    try:
        yield permitted
    finally:
        if permitted:
            _real_time(False)
        sys.setswitchinterval(usual_s)
        gc.unfreeze()


def _real_time(on: bool) -> bool:
    if not hasattr(os, "sched_setscheduler"):
        return False
    policy, priority = (os.SCHED_FIFO, LEAST_PRIORITY) if on else (os.SCHED_OTHER, 0)
    try:
        os.sched_setscheduler(0, policy, os.sched_param(priority))
    except OSError:
        return False
    return True
