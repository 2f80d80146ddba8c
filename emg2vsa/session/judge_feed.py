"""What the judge is told: samples in pieces as they come, where a stay begins, and one question at a time."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from emg2vsa.session.live_press import HowJudged, StayJudged
from emg2vsa.session.press_cycle import LIFTED_S
from emg2vsa.session.presses import Presses, Tried
from emg2vsa.session.recorded_stream import Arrived, RecordedStream
from emg2vsa.session.state import SessionState
from emg2vsa.session.stay_judge import Begin, Judge, JudgeStay, MeasureSignals, Samples
from emg2vsa.session.views import SignalView
from emg2vsa.study import Study

FEED_S = 0.5
"Samples go to the judge in pieces of this length."
SETTLE_S = 0.5
"A press is judged with so much of the rest after it, without which its filters would end within it."
JUDGED_VALUES = 240_000
"The end of a stay with so many samples, over all muscles, is judged within a second."
MENDED_S = 0.9
"A press after a rejected one is judged from so long before its START: what was wrong has been mended by then."
Answer = StayJudged | tuple[SignalView, ...]


def how_judged(study: Study, participant: str, specimen: str) -> HowJudged:
    """The settings by which `emg2vsa check` judges the recording; training is judged as the other specimens are."""
    own = [entry for entry in study.recordings if entry.participant == participant]
    entry = next((entry for entry in own if entry.specimen == specimen), own[0])
    return HowJudged(entry.filters, entry.window, entry.channels.force, study.fit)


def to_judge(presses: Presses, stay: int) -> list[Tried]:
    """The complete attempts of a stay that have no verdict."""
    return [tried for tried in presses.of_stay(stay) if tried.complete and not tried.verdict]


def judged_from_s(presses: Presses, stay: int, begun_s: float, now_s: float, longest_s: float) -> float:
    """The end of a press, s, after which no more than ``longest_s`` has passed; 0: all of the stay, begun at
    ``begun_s``.

    What was badly done and is done again is left behind, with the rest in which its cause was mended: an electrode that
    was off once, or a channel that was clipped, is no fault of what follows.
    """
    own = list(presses.of_stay(stay))
    ends = [tried.ended.stop_s + LIFTED_S for tried in own if tried.ended is not None]
    from_s = 0.0
    for tried, end_s, after in zip(own[:-1], ends[:-1], own[1:], strict=True):
        if tried.verdict == "rejected":
            from_s = max(end_s, after.begun_s - MENDED_S)
    if now_s - max(from_s, begun_s) <= longest_s:
        return from_s
    before = ends[:-1]
    return max(from_s, next((end_s for end_s in before if now_s - end_s <= longest_s), max(before, default=0.0)))


class JudgeFeed:
    """The session's end of its judge.

    asked : what waits for an answer: "stay", a step of the measurement of signals, or "". samples : of each stream the
    first and one past the last one that the last question about a stay was about.
    """

    def __init__(self, judge: Judge, streams: Sequence[RecordedStream], study: Study, participant: str) -> None:
        self._judge, self._streams, self._study, self._participant = judge, tuple(streams), study, participant
        self._columns = {muscle: at for at, muscle in enumerate(study.recordings[0].channels.emg)}
        self._waiting: dict[str, list[Arrived]] = {own.name: [] for own in streams}
        self._next_s = 0.0
        self._first = dict.fromkeys(self._waiting, 0)
        self._epochs = [0] * len(self._streams)
        self._measuring: tuple[str, int] | None = None
        self._measured: dict[str, tuple[int, int]] = {}
        self._ask_at_s: float | None = None
        self.asked = ""
        self.samples: dict[str, tuple[int, int]] = {}
        self._asked_of: list[Tried] = []

    def take(self, stream: str, arrived: Arrived) -> None:
        """Samples that have come; those of one piece follow each other without a gap."""
        waiting = self._waiting[stream]
        if waiting and waiting[-1].first + len(waiting[-1].samples) != arrived.first:
            self._flush(stream)
        self._waiting[stream].append(arrived)

    def begin(self, state: SessionState) -> None:
        """Begin what the judge knows of the stay."""
        specimen = "" if state.stay is None else state.stay.specimen
        self._flush_all()
        how = how_judged(self._study, self._participant, specimen)
        self._judge.tell(Begin(self._participant, specimen, how, self._columns))
        self._first = {own.name: own.next_index for own in self._streams}

    def opened(self, state: SessionState) -> None:
        """A stay begins anew with streams that were opened since."""
        if (epochs := [own.epoch for own in self._streams]) != self._epochs:
            self._epochs = epochs
            self.begin(state)

    def measure(self, step: str, state: SessionState) -> None:
        """Samples of the signal quality begin to come."""
        if step == "rest":
            self.begin(state)
            self._measured = {}
        self._measuring = step, self._streams[0].next_index

    def ended(self, now_s: float) -> None:
        """A press has ended, which is judged once the rest after it has come."""
        self._ask_at_s = now_s + SETTLE_S

    def turn(self, now_s: float, state: SessionState) -> None:
        """Hand over what has come by ``now_s`` (s), every ``FEED_S``, and ask what is due."""
        if now_s >= self._next_s:
            self._next_s = now_s + FEED_S
            self._flush_all()
        if state.measuring is None:
            self._measuring = None
        elif self._measuring is not None and now_s >= state.measuring.until_s:
            self._ask_signals(*self._measuring)
        if self._ask_at_s is not None and now_s >= self._ask_at_s and not self.asked and state.stay is not None:
            self._ask_at_s = None
            self._ask_stay(now_s, state.presses, state.stay.stay)

    def _ask_stay(self, now_s: float, presses: Presses, stay: int) -> None:
        """About the press that has ended, with the stay before it, or as much of that as is judged within a second."""
        self._flush_all()
        stops = {own.name: own.next_index for own in self._streams}
        emg = self._streams[0]
        longest_s = JUDGED_VALUES / (len(self._columns) * emg.info.fs_hz)
        from_s = judged_from_s(presses, stay, emg.clock.time_s(self._first[emg.name]), now_s, longest_s)
        self.samples = {
            own.name: (max(self._first[own.name], own.clock.first_after(from_s, stops[own.name])), stops[own.name])
            for own in self._streams
        }
        self._asked_of, self.asked = to_judge(presses, stay), "stay"
        clocks = {own.name: own.clock for own in self._streams}
        self._judge.tell(JudgeStay({name: clocks[name].timing(*own) for name, own in self.samples.items()}))

    def _ask_signals(self, step: str, first: int) -> None:
        """About all that has been measured so far."""
        self._flush_all()
        self._measuring, self.asked = None, step
        self._measured[step] = first, self._streams[0].next_index
        info, measured = self._streams[0].info, self._measured
        self._judge.tell(
            MeasureSignals(
                measured.get("rest"), measured.get("contraction"), info.fs_hz, self._study.filters, info.range_max
            )
        )  # fmt: skip

    def answer(self) -> tuple[str, Answer, list[Tried]] | None:
        """What was asked, its answer, and the attempts that it is about, once it is there."""
        if not self.asked or (answer := self._judge.answer()) is None:
            return None
        asked, self.asked = self.asked, ""
        return asked, answer, self._asked_of

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
