"""A task that fails, or takes its process down, leaves the others alone; every failure is told apart."""

from __future__ import annotations

import importlib
import multiprocessing
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from emg2vsa.pipeline.run_study import _loads
from emg2vsa.pipeline.stage_order import ORDER, stage
from emg2vsa.pipeline.store import claimed
from emg2vsa.pipeline.tasks import Ended, Workers

DEEDS = """
import os, time
from dataclasses import dataclass
from pathlib import Path
from emg2vsa import artifacts
from emg2vsa.errors import DataError, PassingError
from emg2vsa.pipeline.stage import Given
from emg2vsa.pipeline.tasks import Task, Workers

class Deed(Task):
    def _make(self):
        match self.given.item:
            case "refuse":
                raise DataError("x.csv", wanted="data", found="none", do="Record again.")
            case "slow":
                raise PassingError("x.c3d", wanted="data", found="that it took more than 10 s", do="Export.")
            case "crash":
                raise ZeroDivisionError("by zero")
            case "damaged":
                artifacts.load(Path("absent.result"))
            case "die":
                os._exit(9)
            case "sleep":
                Path(f"{self.step}.pid").write_text(str(os.getpid()))
                time.sleep(60)
        time.sleep(0.02)
        return str(os.getpid())

def deeds(names):
    return [Deed(f"s{i}", Given(name, {}), Path("x"), Path(f"claims/{i}").absolute()) for i, name in enumerate(names)]
"""


@pytest.fixture
def tasks(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., list[Any]]:
    """Tasks that do as their names say; their module is where worker processes find it too."""
    (tmp_path / "deeds_of_tests.py").write_text(DEEDS)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.chdir(tmp_path)
    monkeypatch.delitem(sys.modules, "deeds_of_tests", raising=False)
    module: ModuleType = importlib.import_module("deeds_of_tests")
    return lambda *names: list(module.deeds(names))


def run(workers: Workers, tasks: list[Any]) -> dict[str, Ended]:
    ended: dict[str, Ended] = {}
    workers.run(tasks, lambda e: ended.__setitem__(e.step, e))
    return ended


@pytest.mark.parametrize("jobs", [1, 2])
def test_failures_are_isolated_and_told_apart(jobs: int, tasks: Callable[..., list[Any]]) -> None:
    with Workers(jobs) as workers:
        ended = run(workers, tasks("ok", "refuse", "crash", "damaged", "ok"))
    assert [ended[f"s{i}"].status for i in range(5)] == ["done", "failed", "failed", "failed", "done"]
    assert [ended[f"s{i}"].final for i in range(5)] == [False, True, False, False, False]
    assert ended["s1"].message.startswith("x.csv: expected data, but found none")
    assert "ZeroDivisionError in deeds_of_tests.py" in ended["s2"].message
    assert "please report it" in ended["s2"].message
    assert [ended[f"s{i}"].damaged for i in range(5)] == ["", "", "", "absent.result", ""]
    assert not list(Path("claims").iterdir())


def test_a_step_that_another_process_works_at_is_left_to_it(tasks: Callable[..., list[Any]]) -> None:
    (task,) = tasks("ok")
    with claimed(task.claim):
        ended = task()
        assert task.claim.exists()
    assert (ended.status, ended.final) == ("failed", False)
    assert f"process {os.getpid()}" in ended.message


def test_a_dead_process_costs_only_its_task(tasks: Callable[..., list[Any]]) -> None:
    with Workers(2) as workers:
        ended = run(workers, tasks("ok", "die", "ok", "ok", "ok"))
        assert [ended[f"s{i}"].status for i in range(5)] == ["done", "failed", "done", "done", "done"]
        assert "process died" in ended["s1"].message
        assert not list(Path("claims").iterdir())
        assert [each.status for each in run(workers, tasks("ok", "ok")).values()] == ["done", "done"]


def test_workers_serve_one_stage_after_the_other_and_end_with_the_last(tasks: Callable[..., list[Any]]) -> None:
    with Workers(2) as workers:
        pids = {each.message for _ in range(3) for each in run(workers, tasks("ok", "ok", "ok", "ok")).values()}
        assert 1 <= len(pids - {str(os.getpid())}) <= 2
        assert run(workers, tasks("ok"))["s0"].message == str(os.getpid())  # one task is done here
    assert not {str(child.pid) for child in multiprocessing.active_children()} & pids


@pytest.mark.skipif(not Path("/proc/self").exists(), reason="looks into /proc")
def test_workers_end_with_a_process_that_is_killed(tmp_path: Path, tasks: Callable[..., list[Any]]) -> None:
    main = (
        "from deeds_of_tests import *\nwith Workers(2) as workers:\n"
        "    workers.run(deeds(['ok'] * 4), print)\n    workers.run(deeds(['sleep'] * 2), print)"
    )
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    parent = subprocess.Popen([sys.executable, "-c", main], env=environment, stdout=subprocess.DEVNULL)
    pids = [tmp_path / f"s{i}.pid" for i in range(2)]
    assert soon(lambda: all(path.exists() and path.read_text() for path in pids), 60)
    workers = [Path("/proc", path.read_text()) for path in pids]
    parent.send_signal(signal.SIGKILL)
    parent.wait()
    assert soon(lambda: not any(map(runs, workers)), 60)


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


def test_a_recording_that_was_read_too_slowly_is_tried_again(tasks: Callable[..., list[Any]]) -> None:
    (task,) = tasks("slow")
    ended = task()
    assert (ended.status, ended.final) == ("failed", False)
    assert "more than 10 s" in ended.message


def test_what_workers_load_from_the_start_is_there() -> None:
    for name in ORDER:
        for module in stage(name).loads:
            assert importlib.import_module(module).__name__ == module
    assert {"emg2vsa.worlds.bench.virtual_run", "emg2vsa.run_scores.score_run"} <= set(_loads(ORDER))
    assert "emg2vsa.extraction.extract" not in _loads(ORDER[ORDER.index("emulation") :])
