"""What the judge is told: samples in pieces as they come, where a stay begins, and one question at a time."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from emg2vsa.session.live_press import HowJudged, StayJudged
from emg2vsa.session.recorded_stream import Arrived, RecordedStream
from emg2vsa.session.stay_judge import Begin, Judge, JudgeStay, MeasureSignals, Samples, Timing
from emg2vsa.session.views import SignalView
from emg2vsa.settings import FilterSettings

FEED_S = 0.5
"Samples go to the judge in pieces of this length."
Answer = StayJudged | tuple[SignalView, ...]


class JudgeFeed:
    """The session's end of its judge.

    muscles : of the columns of the EMG that is handed over. asked : what waits for an answer: "stay", a step of the
    measurement of signals, or "".
    """

    def __init__(self, judge: Judge, streams: Sequence[RecordedStream], muscles: Sequence[str]) -> None:
        self._judge, self._streams = judge, tuple(streams)
        self._columns = {muscle: at for at, muscle in enumerate(muscles)}
        self._waiting: dict[str, list[Arrived]] = {own.name: [] for own in streams}
        self._next_s = 0.0
        self._first = dict.fromkeys(self._waiting, 0)
        self.asked = ""

    def take(self, stream: str, arrived: Arrived) -> None:
        """Samples that have come; those of one piece follow each other without a gap."""
        waiting = self._waiting[stream]
        if waiting and waiting[-1].first + len(waiting[-1].samples) != arrived.first:
            self._flush(stream)
        self._waiting[stream].append(arrived)

    def turn(self, now_s: float) -> None:
        """Hand over what has come, every ``FEED_S``."""
        if now_s >= self._next_s:
            self._next_s = now_s + FEED_S
            self._flush_all()

    def begin(self, participant: str, specimen: str, how: HowJudged) -> None:
        """What the judge knows of the stay begins now."""
        self._flush_all()
        self._judge.tell(Begin(participant, specimen, how, self._columns))
        self._first = {own.name: own.next_index for own in self._streams}

    @property
    def start_s(self) -> float:
        """When the stay began, by the clock of the EMG."""
        emg = self._streams[0]
        return emg.timing(self._first[emg.name])[0]

    def ask_stay(self, from_s: float) -> None:
        """How good are the presses of the stay? from_s : what came before is left out; 0: nothing is."""
        self._flush_all()
        timing = {}
        for own in self._streams:
            start_s, fs_hz = own.timing(first := self._first[own.name])
            later = max(0, round((from_s - start_s) * fs_hz)) if from_s else 0
            timing[own.name] = Timing(first + later, *own.timing(first + later))
        self._judge.tell(JudgeStay(timing))
        self.asked = "stay"

    def ask_signals(self, step: str, measured: dict[str, tuple[int, int]], filters: FilterSettings) -> None:
        """How good are the signals? measured : step of the measurement to its first and last-plus-one sample."""
        self._flush_all()
        info = self._streams[0].info
        self._judge.tell(
            MeasureSignals(
                measured.get("rest"), measured.get("contraction"), info.fs_hz, filters, info.range_max,
            )
        )  # fmt: skip
        self.asked = step

    def answer(self) -> tuple[str, Answer] | None:
        """What was asked and its answer, once it is there."""
        if not self.asked or (answer := self._judge.answer()) is None:
            return None
        asked, self.asked = self.asked, ""
        return asked, answer

    def close(self) -> None:
        self._judge.close()

    def _flush_all(self) -> None:
        for stream in self._waiting:
            self._flush(stream)

    def _flush(self, stream: str) -> None:
        if waiting := self._waiting[stream]:
            samples = np.concatenate([each.samples for each in waiting]).astype(np.float32)
            self._judge.tell(Samples(stream, waiting[0].first, samples))
            self._waiting[stream] = []
