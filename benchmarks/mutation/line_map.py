"""Which test files execute a line: a pytest plugin that writes one coverage file per process.

    LINE_MAP=DIR python -m pytest -p benchmarks.mutation.line_map -n auto --dist loadfile ...

Code that runs in child processes is not seen; ``benchmarks.mutation.nearest`` adds the tests of the package.
"""

from __future__ import annotations

import os
from collections.abc import Generator
from pathlib import Path

import coverage
import pytest

_FOLDER = Path(os.environ["LINE_MAP"])
_COVERAGE = coverage.Coverage(
    data_file=str(_FOLDER / ".coverage"), data_suffix=True, source_pkgs=["emg2vsa", "casr"], config_file=False
)


def pytest_configure() -> None:
    """Start before the first test module is imported."""
    _FOLDER.mkdir(parents=True, exist_ok=True)
    _COVERAGE.start()


def pytest_unconfigure() -> None:
    """Write what this process saw."""
    _COVERAGE.stop()
    _COVERAGE.save()


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item: pytest.Item, nextitem: pytest.Item | None) -> Generator[None, bool, bool]:
    """The context of a line is the test file that executes it. A finished file is saved at once."""
    report = yield
    file = item.nodeid.partition("::")[0]
    if nextitem is None or nextitem.nodeid.partition("::")[0] != file:
        _COVERAGE.save()
    return report


def pytest_runtest_logstart(nodeid: str) -> None:
    """Name the file before its fixtures are set up."""
    _COVERAGE.switch_context(nodeid.partition("::")[0])
