"""What judges the presses of a stay and the signals before a session: beside the 200 turns a second, or at once.

The samples of a stay are handed over as they come, so that nothing large moves when a press has ended, and the memory
of the session itself does not grow.
"""

from __future__ import annotations

import contextlib
import pickle
import threading
from collections.abc import Mapping
from dataclasses import dataclass
from queue import SimpleQueue
from typing import Any

import numpy as np
from numpy.typing import NDArray

from casr.child_process import Child, Pipes
from emg2vsa.arrays import Floats
from emg2vsa.recordings import Channel
from emg2vsa.session.live_press import HowJudged, StayJudged, judge_stay
from emg2vsa.session.quality import measured
from emg2vsa.session.sample_clock import Timing
from emg2vsa.session.views import SignalView
from emg2vsa.settings import FilterSettings

JUDGE_ENDED = "the process that judges presses ended; emg2vsa check will judge this press"
_END_S = 2.0
"""Time in which the process that judges must end by itself; afterwards it is killed."""


@dataclass(frozen=True)
class JudgeStay:
    """Asks for the verdicts on the stay so far. timing : by stream."""

    timing: Mapping[str, Timing]


@dataclass(frozen=True)
class MeasureSignals:
    """Asks for the signal quality, the samples since `Begin` being the rest, and those after it the contraction.

    rest, contraction : first sample and one past the last, None where it was not measured.
    """

    rest: tuple[int, int] | None
    contraction: tuple[int, int] | None
    fs_hz: float
    filters: FilterSettings
    range_max_v: float | None


@dataclass(frozen=True)
class Begin:
    """A new stay: samples before are forgotten. muscles : name to column of the EMG stream."""

    participant: str
    specimen: str
    how: HowJudged
    muscles: Mapping[str, int]


@dataclass(frozen=True)
class Samples:
    """Samples (n, channels) of a stream, "emg" or "force", that follow one another from number ``first``."""

    stream: str
    first: int
    samples: NDArray[np.float32]


Answer = StayJudged | tuple[SignalView, ...]


Message = Begin | Samples | JudgeStay | MeasureSignals


class JudgeAtOnce:
    """Judges within the call: for virtual time, and at the far end of `JudgeBeside`.

    ``tell`` takes messages in their order and never waits for an answer; ``answer`` hands over the answer to the last
    question, once, when it is there.
    """

    def __init__(self) -> None:
        self._begun: Begin | None = None
        self._samples: dict[str, list[Samples]] = {}
        self._answer: Answer | None = None

    def tell(self, message: Message) -> None:
        match message:
            case Begin():
                self._begun, self._samples = message, {}
            case Samples():
                self._samples.setdefault(message.stream, []).append(message)
            case JudgeStay():
                self._answer = self._stay(message)
            case MeasureSignals():
                self._answer = self._signals(message)

    def answer(self) -> Answer | None:
        answer, self._answer = self._answer, None
        return answer

    def close(self) -> None:
        self._samples = {}

    def _stay(self, asked: JudgeStay) -> StayJudged:
        begun = self._begun
        if begun is None or not {"emg", "force"} <= self._samples.keys():
            return StayJudged(failed="no samples have come")
        emg, force = asked.timing["emg"], asked.timing["force"]
        (newton,) = self._rows("force", force, None).T
        return judge_stay(
            self._channels(emg, None), _channel("force", newton, "N", force), begun.participant, begun.specimen,
            begun.how,
        )  # fmt: skip

    def _signals(self, asked: MeasureSignals) -> tuple[SignalView, ...]:
        rest, contraction = (
            None if part is None else self._channels(Timing(part[0], 0.0, asked.fs_hz), part[1])
            for part in (asked.rest, asked.contraction)
        )
        return measured(rest, contraction, asked.filters, asked.range_max_v)

    def _channels(self, timing: Timing, stop: int | None) -> dict[str, Channel]:
        assert self._begun is not None
        rows = self._rows("emg", timing, stop)
        return {muscle: _channel(muscle, rows[:, at], "V", timing) for muscle, at in self._begun.muscles.items()}

    def _rows(self, stream: str, timing: Timing, stop: int | None) -> Floats:
        """(n, channels) samples from a number on; NaN for those that are not there, or never came."""
        pieces, first = self._samples[stream], timing.first
        last = max(piece.first + len(piece.samples) for piece in pieces) if stop is None else stop
        rows = np.full((max(last - first, 0), pieces[0].samples.shape[1]), np.nan)
        for piece in pieces:
            low, high = max(piece.first, first), min(piece.first + len(piece.samples), last)
            if low < high:
                rows[low - first : high - first] = piece.samples[low - piece.first : high - piece.first]
        return np.insert(rows, [number - first for number, n in timing.lost for _ in range(n)], np.nan, axis=0)


def _channel(name: str, samples: Floats, unit: str, timing: Timing) -> Channel:
    return Channel(name, np.ascontiguousarray(samples), unit, timing.fs_hz, timing.start_s, "")


class JudgeBeside:
    """Judges in a process of its own. A judge that dies is told as a stay that could not be judged.

    A thread sends, for a judge at work does not take what it is told, and the session cannot wait.
    """

    def __init__(self) -> None:
        self._begun: Begin | None = None
        self._asked = False
        self._start()

    def tell(self, message: Message) -> None:
        if isinstance(message, Begin):
            self._begun = message
        self._asked |= isinstance(message, (JudgeStay, MeasureSignals))
        self._messages.put(message)

    def answer(self) -> Answer | None:
        if not self._asked:
            return None
        try:
            if self._child.pipes.readable():
                answer: Answer = pickle.loads(self._child.pipes.receive().data)
                self._asked = False
                return answer
        except (EOFError, OSError):
            self._asked = False
            self.close()
            self._start()
            if self._begun is not None:
                self.tell(self._begun)
            return StayJudged(failed=JUDGE_ENDED)
        return None

    def close(self) -> None:
        self._messages.put(None)
        self._child.end()  # at once: nobody waits for what it may be judging
        self._sender.join(_END_S)

    def _start(self) -> None:
        self._child = Child("emg2vsa.session.stay_judge", "serve", quiet=False)
        self._messages: SimpleQueue[Any] = SimpleQueue()
        arguments = (self._messages, self._child.pipes)
        self._sender = threading.Thread(target=_send, args=arguments, name="to the judge", daemon=True)
        self._sender.start()


Judge = JudgeAtOnce | JudgeBeside


def _send(messages: SimpleQueue[Any], judge: Pipes) -> None:
    with contextlib.suppress(OSError, ValueError):  # a judge that died, or was ended; ``answer`` tells it
        while (message := messages.get()) is not None:
            judge.send(pickle.dumps(message, pickle.HIGHEST_PROTOCOL))


def serve(session: Pipes) -> None:
    """The far end: until the near one is closed."""
    judge = JudgeAtOnce()
    while True:
        judge.tell(pickle.loads(session.receive().data))
        if (answer := judge.answer()) is not None:
            session.send(pickle.dumps(answer, pickle.HIGHEST_PROTOCOL))
