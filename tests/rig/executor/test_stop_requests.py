"""Signals and the stop file as reasons to stop."""

from __future__ import annotations

import os
import signal
import time
from pathlib import Path

import pytest

from emg2vsa.rig.executor.stop_requests import STOP_FILE, StopRequests


@pytest.mark.parametrize(
    ("number", "reason"), [("SIGTERM", "SIGTERM"), ("SIGHUP", "SIGHUP"), ("SIGQUIT", "SIGQUIT"), ("SIGINT", "Ctrl-C")]
)
def test_a_signal_is_a_reason_and_the_old_handlers_come_back(number: str, reason: str, tmp_path: Path) -> None:
    before = [signal.getsignal(one) for one in (signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT, signal.SIGINT)]
    with StopRequests(tmp_path) as stop:
        assert stop() is None
        os.kill(os.getpid(), getattr(signal, number))
        assert stop() == reason
        assert stop() == reason
    assert [signal.getsignal(one) for one in (signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT, signal.SIGINT)] == before


def test_the_first_reason_counts(tmp_path: Path) -> None:
    with StopRequests(tmp_path) as stop:
        os.kill(os.getpid(), signal.SIGHUP)
        os.kill(os.getpid(), signal.SIGTERM)
        assert stop() == "SIGHUP"


def test_the_second_ctrl_c_interrupts_a_loop_that_hangs_and_no_other_does(tmp_path: Path) -> None:
    before = signal.getsignal(signal.SIGINT)
    with StopRequests(tmp_path) as stop:
        os.kill(os.getpid(), signal.SIGINT)
        with pytest.raises(KeyboardInterrupt):
            os.kill(os.getpid(), signal.SIGINT)
        for _ in range(20):
            os.kill(os.getpid(), signal.SIGINT)
        assert stop() == "Ctrl-C"
    assert signal.getsignal(signal.SIGINT) == before


def test_no_ctrl_c_interrupts_the_way_out(tmp_path: Path) -> None:
    with StopRequests(tmp_path) as stop:
        os.kill(os.getpid(), signal.SIGINT)
        assert stop() == "Ctrl-C"
        for _ in range(20):
            os.kill(os.getpid(), signal.SIGINT)
        assert stop() == "Ctrl-C"


@pytest.mark.parametrize(
    ("text", "reason"),
    [("the page", "the page"), ("two\n  lines \n", "two lines"), ("", "file stop"), ("x" * 999, "x" * 200)],
)
def test_the_text_of_the_stop_file_is_the_reason(text: str, reason: str, tmp_path: Path) -> None:
    stop = StopRequests(tmp_path / "run")
    assert stop() is None  # no folder yet
    (tmp_path / "run").mkdir()
    assert stop() is None
    (tmp_path / "run" / STOP_FILE).write_text(text)
    assert stop() == reason


def test_bytes_that_are_no_text_stop_as_well(tmp_path: Path) -> None:
    (tmp_path / STOP_FILE).write_bytes(b"\xff!")
    assert StopRequests(tmp_path)() == "\ufffd!"


def test_the_stop_file_is_seen_soon_while_a_run_goes_on_without_a_look_at_the_disk(tmp_path: Path) -> None:
    with StopRequests(tmp_path) as stop:
        (tmp_path / STOP_FILE).write_text("the page")
        end_s = time.monotonic() + 60
        while stop() is None and time.monotonic() < end_s:
            time.sleep(0.001)
        assert stop() == "the page"
