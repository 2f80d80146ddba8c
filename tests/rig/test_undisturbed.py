"""What a run asks of the system and of Python is taken back at its end."""

from __future__ import annotations

import gc
import os
import sys

import pytest

from emg2vsa.devices.clock import LEAST_PRIORITY, undisturbed


def test_everything_is_as_before_after_an_error() -> None:
    gc.unfreeze()
    before = (os.sched_getscheduler(0), sys.getswitchinterval(), gc.get_freeze_count())

    def failing() -> None:
        with undisturbed():
            assert sys.getswitchinterval() < before[1]
            assert gc.get_freeze_count() > before[2]
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        failing()
    assert (os.sched_getscheduler(0), sys.getswitchinterval(), gc.get_freeze_count()) == before


def test_it_says_whether_the_system_permits_real_time(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[tuple[int, int]] = []
    monkeypatch.setattr(
        os, "sched_setscheduler", lambda pid, policy, param: asked.append((policy, param.sched_priority))
    )
    with undisturbed() as permitted:
        assert permitted
    assert asked == [(os.SCHED_FIFO, LEAST_PRIORITY), (os.SCHED_OTHER, 0)]


def test_where_real_time_is_refused_the_run_goes_on(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(pid: int, policy: int, param: os.sched_param) -> None:
        raise PermissionError(1, "Operation not permitted")

    monkeypatch.setattr(os, "sched_setscheduler", refuse)
    with undisturbed() as permitted:
        assert not permitted
        assert os.sched_getscheduler(0) == os.SCHED_OTHER


def test_where_the_system_knows_no_real_time(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delattr(os, "sched_setscheduler")
    with undisturbed() as permitted:
        assert not permitted
