"""Two programs at once on one study: the second waits, or says who works there and since when."""

from __future__ import annotations

import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from emg2vsa.cli import main
from emg2vsa.pipeline.lock import holder

pytestmark = pytest.mark.slow
RUN = [sys.executable, "-m", "emg2vsa.cli", "run", "--jobs", "1"]


def started(study: Path, part: list[str]) -> subprocess.Popen[str]:
    """A run that holds the study's lock by now."""
    process = subprocess.Popen([*RUN, *part, str(study)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    end = time.monotonic() + 60
    while f"process {process.pid} " not in holder(study.parent / ".emg2vsa" / "small") and time.monotonic() < end:
        assert process.poll() is None, process.communicate()
        time.sleep(0.01)
    return process


def emptied(study: Path) -> dict[str, bytes]:
    """Nothing was run yet. What was stored of the part that a run of people makes."""
    store = study.parent / ".emg2vsa" / "small" / "store"
    parts = ("trials", "fits", "hypotheses", "profiles", "schedules")
    before = {str(path): path.read_bytes() for part in parts for path in (store / part).rglob("*.result")}
    shutil.rmtree(store.parent)
    return before


def test_the_second_waits_and_both_are_done(study: Path) -> None:
    before = {path: data for path, data in emptied(study).items() if "/hypotheses/" not in path}
    part = ["--only", "schedules"]
    first = started(study, part)
    os.kill(first.pid, signal.SIGSTOP)  # until the second waits
    second = subprocess.Popen([*RUN, *part, str(study)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert second.stderr is not None
    waits = second.stderr.readline()
    os.kill(first.pid, signal.SIGCONT)
    (told, errors), (told_2, errors_2) = first.communicate(), second.communicate()
    assert (first.returncode, second.returncode) == (0, 0), (errors, errors_2)
    assert waits.startswith("Waiting: another run holds ")
    assert f"process {first.pid} on " in waits
    assert "0 refused or failed" in told
    assert "0 steps run" in told_2
    assert {path: Path(path).read_bytes() for path in before} == before


def test_without_waiting_the_second_names_the_first_and_a_killed_one_is_no_hindrance(
    study: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = {
        path: data for path, data in emptied(study).items() if "/profiles/" not in path and "/schedules/" not in path
    }
    first = started(study, ["--only", "hypotheses"])
    os.kill(first.pid, signal.SIGSTOP)  # it holds the study for as long as this test looks
    capsys.readouterr()
    assert main(["run", str(study), "--no-wait", "--jobs", "1"]) == 2
    told = capsys.readouterr().err
    assert main(["status", str(study)]) == 0
    assert f"A run is under way: process {first.pid} on" in capsys.readouterr().out
    first.kill()
    first.communicate()
    assert re.search(rf"results in use by process {first.pid} on .+, since \d\d:\d\d:\d\d on \d{{4}}-\d\d-\d\d", told)
    assert main(["run", str(study), "--only", "hypotheses", "--no-wait", "--jobs", "1", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["failures"] == []
    assert {path: Path(path).read_bytes() for path in before} == before
    assert list((study.parent / ".emg2vsa" / "small" / "under-way").iterdir()) == []
