"""The process that judges presses: it answers, its death is told and costs one answer, and no session waits for it."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Iterator

import numpy as np
import pytest

from emg2vsa.session.live_press import StayJudged
from emg2vsa.session.sample_clock import Timing
from emg2vsa.session.stay_judge import Answer, JudgeAtOnce, JudgeBeside, JudgeStay, MeasureSignals, Samples
from emg2vsa.settings import FilterSettings

ENDED = "the process that judges presses ended; emg2vsa check will judge this press"


@pytest.fixture
def beside() -> Iterator[JudgeBeside]:
    judge = JudgeBeside()
    yield judge
    judge.close()


def answer_of(judge: JudgeBeside) -> Answer:
    end_s = time.monotonic() + 60.0
    while (answer := judge.answer()) is None and time.monotonic() < end_s:
        time.sleep(0.005)
    assert answer is not None
    return answer


def test_it_answers_as_one_in_the_session_does(beside: JudgeBeside) -> None:
    here = JudgeAtOnce()
    for judge in (here, beside):
        judge.tell(Samples("emg", 0, np.zeros((200_000, 2), np.float32)))  # more than a pipe holds
        judge.tell(JudgeStay({}))
    assert answer_of(beside) == here.answer() == StayJudged(failed="no samples have come")
    assert beside.answer() is None  # handed over once
    beside.tell(MeasureSignals(None, None, 1000.0, FilterSettings(), None))
    assert answer_of(beside) == ()


def test_samples_that_never_came_are_gaps_where_the_clock_says() -> None:
    judge = JudgeAtOnce()
    judge.tell(Samples("force", 10, np.arange(6, dtype=np.float32)[:, None]))
    rows = judge._rows("force", Timing(11, 0.0, 1000.0, ((12, 1), (14, 2))), None)
    np.testing.assert_array_equal(rows[:, 0], [1, np.nan, 2, 3, np.nan, np.nan, 4, 5])


def test_a_judge_that_is_killed_is_told_once_and_the_next_one_answers(beside: JudgeBeside) -> None:
    beside.tell(JudgeStay({}))
    answer_of(beside)
    os.kill(beside._child.pid, signal.SIGKILL)
    beside.tell(JudgeStay({}))
    assert answer_of(beside) == StayJudged(failed=ENDED)
    beside.tell(JudgeStay({}))
    assert answer_of(beside) == StayJudged(failed="no samples have come")


def test_nobody_waits_for_a_judge_that_hangs_and_it_is_ended(beside: JudgeBeside) -> None:
    beside.tell(JudgeStay({}))
    answer_of(beside)
    pid = beside._child.pid
    os.kill(pid, signal.SIGSTOP)
    for i in range(20):  # far more than a pipe holds: who waited for it would wait for ever
        beside.tell(Samples("emg", 50_000 * i, np.zeros((50_000, 2), np.float32)))
        assert beside.answer() is None
    beside.close()
    with pytest.raises(ProcessLookupError):
        os.kill(pid, 0)
