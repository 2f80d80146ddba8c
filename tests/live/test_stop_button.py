"""The stop file, from the button to the executor."""

from __future__ import annotations

from pathlib import Path

import pytest

from emg2vsa.rig.executor.stop_requests import StopRequests, request_stop, stop_requested

REASON = "STOP on the live page"


def test_the_executor_reads_the_reason(tmp_path):
    asked = StopRequests(tmp_path)
    assert asked() is None
    assert not stop_requested(tmp_path)
    request_stop(tmp_path, REASON)
    assert asked() == REASON
    assert stop_requested(tmp_path)


def test_a_second_click_changes_nothing(tmp_path):
    (tmp_path / "stop").write_text("somebody at the shell")
    before = (tmp_path / "stop").stat()
    request_stop(tmp_path, REASON)
    assert StopRequests(tmp_path)() == "somebody at the shell"
    assert (tmp_path / "stop").stat().st_ino == before.st_ino


def test_the_file_appears_whole_or_not_at_all(tmp_path, monkeypatch):
    seen = []

    def renamed(source, target):
        seen.append((Path(source).read_text(), target.exists()))
        raise OSError("no room")

    monkeypatch.setattr("casr.atomic.os.replace", renamed)
    with pytest.raises(OSError, match="no room"):
        request_stop(tmp_path, REASON)
    assert seen == [(f"{REASON}\n", False)]
    assert list(tmp_path.iterdir()) == []
    assert not stop_requested(tmp_path)
