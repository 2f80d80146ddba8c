"""What stops ``emg2vsa rig run``: the stop file, and signals to its process."""

from __future__ import annotations

import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import pytest

from benchmarks.rig.fault_case import read_log
from tests.cli.rig.conftest import MOTORS_OFF, ended_of, motors

pytestmark = pytest.mark.realtime
Rig = Callable[..., tuple[int, str, str]]
ONE = ("--specimen", "S1", "--angle", "0", "--condition", "modular")


def wait_for_presses(folder: Path) -> None:
    """Until the log says that a press has begun; fails when it does not."""
    for _ in range(600):
        if (folder / "log.csv").exists() and ",approach," in (folder / "log.csv").read_text():
            return
        time.sleep(0.05)
    pytest.fail("no press has begun")


def test_the_stop_file_ends_a_run_with_its_text(rig: Rig, served: SimpleNamespace, tmp_path: Path) -> None:
    folder = tmp_path / "runs" / "S1_0_modular"

    def press_stop() -> None:
        wait_for_presses(folder)
        (folder / "stop").write_text("seen enough\n")

    button = threading.Thread(target=press_stop)
    button.start()
    status, out, _ = rig("run", served.path, *ONE, "--repetitions", 500)
    button.join()
    assert status == 1
    assert "\nstopped: seen enough in " in out
    assert ended_of(folder)["cause"] == "seen enough"


def test_a_signal_ends_a_process_safely(served: SimpleNamespace, tmp_path: Path) -> None:
    folder = tmp_path / "runs" / "S1_0_modular"
    command = [sys.executable, "-m", "emg2vsa.cli", "rig", "run", str(served.path), *ONE, "--repetitions", "500"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        wait_for_presses(folder)
        process.terminate()
        out, err = process.communicate(timeout=30)
    assert process.returncode == 1, err
    assert "\nstopped: SIGTERM in " in out
    ended = ended_of(folder)
    assert (ended["how"], ended["cause"], ended["retracted"], ended["deactivated"]) == (
        "stopped",
        "SIGTERM",
        True,
        True,
    )
    rows = read_log(folder / "log.csv")
    assert len(rows) == ended["rows"]
    assert rows[-1].position_deg == 0
    assert motors(served.bench) == MOTORS_OFF
