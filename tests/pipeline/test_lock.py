"""One writer at a time: the second waits or is told who the first is; a killed one holds nothing."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from emg2vsa.errors import DataError
from emg2vsa.pipeline.lock import holder, study_lock

HOLD = """
import sys, time
from pathlib import Path
from emg2vsa.pipeline.lock import study_lock
with study_lock(Path(sys.argv[1]), wait=True, say=print):
    print("held", flush=True)
    time.sleep(60)
"""


@pytest.fixture
def other(tmp_path: Path) -> Iterator[subprocess.Popen[str]]:
    """Another process that holds the lock of ``tmp_path``."""
    with subprocess.Popen([sys.executable, "-c", HOLD, str(tmp_path)], stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "held\n"
        yield process
        process.kill()


def test_without_waiting_the_holder_is_named(tmp_path: Path, other: subprocess.Popen[str]) -> None:
    named = rf"results in use by process {other.pid} on .+, since \d\d:\d\d:\d\d on \d{{4}}-\d\d-\d\d"
    with pytest.raises(DataError, match=named), study_lock(tmp_path, wait=False, say=pytest.fail):
        pass
    assert str(other.pid) in holder(tmp_path)


def test_a_killed_holder_leaves_no_lock_and_who_waits_goes_on(tmp_path: Path, other: subprocess.Popen[str]) -> None:
    said: list[str] = []

    def say(text: str) -> None:
        said.append(text)
        threading.Timer(0.3, os.kill, (other.pid, signal.SIGKILL)).start()

    start = time.monotonic()
    with study_lock(tmp_path, wait=True, say=say):
        assert time.monotonic() - start > 0.2
    assert len(said) == 1
    assert f"process {other.pid} " in said[0]
    assert holder(tmp_path) == ""


def test_looking_at_the_lock_makes_nothing(tmp_path: Path) -> None:
    assert holder(tmp_path / "none") == ""
    assert list(tmp_path.iterdir()) == []
