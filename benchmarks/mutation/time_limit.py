"""A test that no longer ends is ended, and the whole run with it: a pytest plugin for mutants."""

from __future__ import annotations

import os
import signal
from collections.abc import Generator
from types import FrameType

import pytest

CPU_S, WALL_S, EXIT_CODE = 60.0, 400.0, 124
"""Processor time and wall time of one test; the slowest fast test takes a third of the first on the unchanged code."""


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
    return report
