"""A task that fails, or takes its process down, leaves the others alone."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from emg2vsa.errors import DataError
from emg2vsa.pipeline.pool import run_tasks
from emg2vsa.pipeline.tasks import Ended, Task, guarded


def work(step: str, deed: str) -> list[Ended]:
    """What the tasks of this file do, named by ``tests_work``."""

    def make() -> None:
        if deed == "refuse":
            raise DataError("x.csv", wanted="data", found="none", do="Record again.")
        if deed == "crash":
            raise ZeroDivisionError("by zero")
        if deed == "die":
            os._exit(9)
        if deed == "sleep":
            Path(f"{step}.pid").write_text(str(os.getpid()))
            time.sleep(60)

    return [guarded(step, make)]


def tasks(deeds: list[str], monkeypatch: pytest.MonkeyPatch) -> list[Task]:
    monkeypatch.setenv("PYTHONPATH", os.path.dirname(__file__))
    return [Task((f"s{i}",), "test_pool:work", {"step": f"s{i}", "deed": deed}) for i, deed in enumerate(deeds)]


@pytest.mark.parametrize("jobs", [1, 2])
def test_failures_are_isolated_and_told_apart(jobs: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(os.path.dirname(__file__))
    ended: dict[str, Ended] = {}
    run_tasks(tasks(["ok", "refuse", "crash", "ok"], monkeypatch), jobs, lambda e: ended.__setitem__(e.step, e))
    assert [ended[f"s{i}"].status for i in range(4)] == ["done", "failed", "failed", "done"]
    assert ended["s1"].final
    assert "x.csv: wanted data; found none" in ended["s1"].message
    assert not ended["s2"].final
    assert "ZeroDivisionError in test_pool.py" in ended["s2"].message


def test_a_dead_process_costs_only_its_task(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(os.path.dirname(__file__))
    ended: dict[str, Ended] = {}
    run_tasks(tasks(["ok", "die", "ok", "ok", "ok"], monkeypatch), 2, lambda e: ended.__setitem__(e.step, e))
    assert [ended[f"s{i}"].status for i in range(5)] == ["done", "failed", "done", "done", "done"]
    assert "process died" in ended["s1"].message


@pytest.mark.skipif(not Path("/proc/self").exists(), reason="looks into /proc")
def test_workers_end_with_a_process_that_is_killed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    main = "import test_pool as t, pytest; t.run_tasks(t.tasks(['sleep'] * 2, pytest.MonkeyPatch()), 2, print)"
    monkeypatch.setenv("PYTHONPATH", os.path.dirname(__file__))
    parent = subprocess.Popen([sys.executable, "-c", main], cwd=tmp_path)
    pids = [tmp_path / f"s{i}.pid" for i in range(2)]
    assert soon(lambda: all(path.exists() and path.read_text() for path in pids), 30)
    workers = [Path("/proc", path.read_text()) for path in pids]
    parent.send_signal(signal.SIGKILL)
    parent.wait()
    assert soon(lambda: not any(map(runs, workers)), 3)


def runs(process: Path) -> bool:
    """Is there such a process? One that ended and whose end nobody has taken note of is none."""
    try:
        return (process / "stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def soon(happened: Callable[[], bool], within_s: float) -> bool:
    end = time.monotonic() + within_s
    while not happened() and time.monotonic() < end:
        time.sleep(0.02)
    return happened()
