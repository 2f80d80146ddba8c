"""A test that no longer ends is ended, and its run with it; a run over its budget is too: a plugin for mutants."""

from __future__ import annotations

import os
import resource
import signal
import sys
from collections.abc import Generator
from types import FrameType

import pytest

CPU_S, WALL_S, EXIT_CODE = 60.0, 400.0, 124
"""Processor time and wall time of one test; the slowest fast test takes a third of the first on the unchanged code."""

BUDGET_S = 40.0
"""Processor time of a run up to its first failure, and of its child processes; no test begins after it."""
OVER_BUDGET = "the budget of processor time is used up"


assert sys.platform != "win32", "clocks of tests need POSIX"


def _end(number: int, frame: FrameType | None) -> None:
    os._exit(EXIT_CODE)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item: pytest.Item) -> Generator[None, bool, bool]:
    """Both clocks run while the test and its fixtures do."""
    for number in (signal.SIGPROF, signal.SIGALRM):
        signal.signal(number, _end)
    signal.setitimer(signal.ITIMER_PROF, CPU_S)
    signal.setitimer(signal.ITIMER_REAL, WALL_S)
    report = yield
    signal.setitimer(signal.ITIMER_PROF, 0)
    signal.setitimer(signal.ITIMER_REAL, 0)
    usages = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    up_to_first_failure = item.config.getoption("maxfail") == 1
    if up_to_first_failure and sum(usage.ru_utime + usage.ru_stime for usage in usages) > BUDGET_S:
        item.session.shouldstop = OVER_BUDGET
    return report


def pytest_sessionfinish(session: pytest.Session) -> None:
    """A run without a failure up to the end of its budget has passed."""
    if session.shouldstop == OVER_BUDGET and not session.testsfailed:
        session.exitstatus = pytest.ExitCode.OK
