"""CPU time of each test file, its own child processes included: a pytest plugin.

    python -m pytest -p benchmarks.suite_cpu -n auto --dist loadfile ...

Wall time lies on a machine that is busy with other work; CPU time hardly does. A file's CPU time is that of the
processes that ran its tests and fixtures, and of their child processes: of those that have ended as the system tells,
of those that live (a fork server with the workers that it ran) as /proc has them, where there is one.
"""

from __future__ import annotations

import os
import resource
from collections import defaultdict
from collections.abc import Generator
from pathlib import Path

import pytest


def _cpu_s() -> float:
    usages = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return sum(usage.ru_utime + usage.ru_stime for usage in usages) + sum(map(_live_s, _children(os.getpid())))


def _children(process: int) -> list[int]:
    """Live child processes, as /proc lists them by the threads that started them."""
    found = []
    for listed in Path(f"/proc/{process}/task").glob("*/children"):
        try:
            found += [int(child) for child in listed.read_text().split()]
        except OSError:  # the thread has ended
            continue
    return found


def _live_s(process: int) -> float:
    """CPU time of a live process, of its ended children and of its live ones."""
    try:
        fields = Path(f"/proc/{process}/stat").read_text().rpartition(") ")[2].split()
    except OSError:  # it has ended: its parent has its time from now on
        return 0.0
    own = sum(map(int, fields[11:15])) / os.sysconf("SC_CLK_TCK")  # utime, stime, cutime, cstime: proc(5)
    return own + sum(map(_live_s, _children(process)))


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item: pytest.Item) -> Generator[None, bool, bool]:
    """Keep what the test and its fixtures took with the report of its teardown."""
    item.stash[_STARTED] = _cpu_s()
    return (yield)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(
    item: pytest.Item, call: pytest.CallInfo[None]
) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Reports travel from the workers to the terminal: they carry the CPU time."""
    report = yield
    if call.when == "teardown":
        report.user_properties.append(("cpu_s", _cpu_s() - item.stash[_STARTED]))
    return report


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Print the files, those with most CPU time first, then the longest tests."""
    files: dict[str, float] = defaultdict(float)
    tests: dict[str, float] = {}
    for reports in terminalreporter.stats.values():
        for report in reports:
            properties = getattr(report, "user_properties", ())
            for seconds in (value for name, value in properties if name == "cpu_s" and report.when == "teardown"):
                files[report.nodeid.partition("::")[0]] += seconds
                tests[report.nodeid] = seconds
    for title, table, shown in (("files", files, len(files)), ("tests", tests, 100)):
        terminalreporter.section(f"CPU time of {title}: {sum(table.values()):.1f} s")
        for name, seconds in sorted(table.items(), key=lambda row: -row[1])[:shown]:
            terminalreporter.write_line(f"{seconds:8.2f} s  {name}")


_STARTED = pytest.StashKey[float]()
