"""One participant's session: 200 turns a second from the samples that have come to what the pages show.

A turn reads the sources (whose samples go to the disk first), filters the bar's force, moves the command on, hands what
has come to the judge, writes what happened into the journal, and renews the views. What the operator asks for is taken
between two turns, from any thread.
"""

from __future__ import annotations

import platform
import threading
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from emg2vsa import __version__
from emg2vsa.arrays import Floats
from emg2vsa.errors import SettingError
from emg2vsa.rig.clock import Beat, Clock
from emg2vsa.session import journal, quality
from emg2vsa.session.bar_force import BarForce
from emg2vsa.session.live_fit import specimen_fit
from emg2vsa.session.live_press import Circumstances, HowJudged, StayJudged, judge_attempt
from emg2vsa.session.plan import PlannedPress
from emg2vsa.session.press_cycle import Attempt, PressCycle
from emg2vsa.session.press_list import PressList, Tried, judged_event, said_the_same
from emg2vsa.session.record import SessionRecord
from emg2vsa.session.recorded_stream import Arrived, RecordedStream
from emg2vsa.session.stay_judge import Begin, Judge, JudgeStay, MeasureSignals, Samples, Timing
from emg2vsa.session.traces import Traces
from emg2vsa.session.views import (
    Command,
    ForceMessage,
    OperatorState,
    ParticipantState,
    Request,
    ScreenReport,
    SignalView,
    SpecimenFit,
)
from emg2vsa.session_settings import SessionSettings
from emg2vsa.study import Study

TURN_S = 0.005
SETTLE_S = 0.5
"A press is judged with so much of the rest after it, without which its filters would end within it."
FEED_S = 0.5
"Samples go to the judge in pieces of this length."
ZERO_S, STEADY_N = 0.5, 0.2
"The zero of force is the mean over this time, in which the force must not change by more."
STATE_S, CLOCK_TOLD_S, SCREEN_TOLD_S = 1.0, 60.0, 10.0
"How often the devices are looked at, their clocks are told to the journal, and a screen without news is."
_MOST_WARNINGS = 8


@dataclass(frozen=True)
class _Measurement:
    step: str
    until_s: float
    first: int


class Session:
    """A session between its sources, its record and its pages.

    ``turn`` belongs to one thread; ``ask``, ``screen`` and the newest views may be used by any.
    """

    def __init__(
        self,
        study: Study,
        settings: SessionSettings,
        record: SessionRecord,
        streams: tuple[RecordedStream, RecordedStream],
        judge: Judge,
        changes: tuple[str, ...] = (),
    ) -> None:
        """streams : of EMG and force, open. judge : closed by the session. changes : of the study file on resume."""
        self._study, self._settings, self._record, self._judge = study, settings, record, judge
        self._emg, self._force = streams
        self._lock = threading.RLock()
        self._now_s = 0.0
        self._muscles = tuple(study.recordings[0].channels.emg)
        self.participant = record.plan.participant
        self._bar = BarForce(settings.bar_filter_hz)
        self._cycle = PressCycle(settings, study.window.max_duration_s)
        self.presses = PressList(record.progress)
        for line in record.past:
            self.presses.take(line.event)
        self.traces = Traces(self._muscles)
        self._recent: deque[tuple[float, Floats]] = deque()
        self._feeding: dict[str, list[Arrived]] = {"emg": [], "force": []}
        self._next_feed_s = 0.0
        # of the time before the first press
        self._measuring: _Measurement | None = None
        self._measured: dict[str, tuple[int, int]] = {}
        self._signals: tuple[SignalView, ...] = ()
        self._quality_done = False
        # of the specimen on the table
        self._stay: PlannedPress | None = None
        self._placed = False
        self._checked = dict.fromkeys(settings.checklist, False)
        self._stay_first = {"emg": 0, "force": 0}
        self._epochs = (0, 0)
        self._pause_until_s = 0.0
        self._paused = ""
        self._judged = StayJudged()
        self._judge_at_s: float | None = None
        self._asked: str = ""
        self._suggested: PlannedPress | None = None
        self._declined: set[str] = set()
        self._fits: dict[str, SpecimenFit] = {}
        # of the attempt that runs
        self._running: Tried | None = None
        self._lost_at_start: tuple[int, int] = (0, 0)
        self._screens: list[ScreenReport] = []
        self._screen: ScreenReport | None = None
        self._screen_told_s = -SCREEN_TOLD_S
        self.verdict_delays_s: list[float] = []
        "From the end of each press to its verdict."
        # what is shown
        self._said: deque[str] = deque(maxlen=_MOST_WARNINGS)
        self._message = ""
        self._sequence = 0
        self._next_state_s = self._next_clock_s = 0.0
        self._overdue = False
        self._command: Command = "wait"
        self._closing = ""
        self.ended: journal.Ended | None = None
        self.force_message = ForceMessage(0, 0.0, 0.0, "none", "", "wait")
        self._changed = True
        self._begin(changes)
        self.participant_state = self._participant_state()
        self.operator_state: tuple[int, OperatorState] = (1, self._operator_state())

    # the turn

    def turn(self, now_s: float) -> None:
        """Everything that has come until now, and everything that follows from it."""
        with self._lock:
            self._now_s = now_s
            for arrived in self._force.read(now_s):
                self._take_force(arrived)
            for arrived in self._emg.read(now_s):
                self._take_emg(arrived)
            self._watch(now_s)
            self._open_or_close(now_s)
            if (attempt := self._cycle.turn(now_s, self._bar.force_n)) is not None:
                self._over(attempt)
            elif self._cycle.attempt is not None and self._running is None:
                self._press_begun(self._cycle.attempt)
            self._work(now_s)
            self._show(now_s)

    def _take_force(self, arrived: Arrived) -> None:
        newton = arrived.samples[:, 0]
        self._bar.take(newton, self._force.info.fs_hz, arrived.newest_s)
        self._newest_force_s = arrived.newest_s
        self._recent.append((self._now_s, newton))
        while self._recent and self._recent[0][0] < self._now_s - ZERO_S:
            self._recent.popleft()
        self._feed("force", arrived)

    def _take_emg(self, arrived: Arrived) -> None:
        columns = [self._emg.info.channels.index(muscle) for muscle in self._muscles]
        self.traces.emg(arrived.samples[:, columns], self._emg.info.fs_hz)
        self._feed("emg", arrived._replace(samples=arrived.samples[:, columns]))

    def _feed(self, stream: str, arrived: Arrived) -> None:
        waiting = self._feeding[stream]
        if waiting and waiting[-1].first + len(waiting[-1].samples) != arrived.first:
            self._flush(stream)
        self._feeding[stream].append(arrived)

    def _flush(self, stream: str) -> None:
        if waiting := self._feeding[stream]:
            samples = np.concatenate([each.samples for each in waiting]).astype(np.float32)
            self._judge.tell(Samples(stream, waiting[0].first, samples))
            self._feeding[stream] = []

    def _watch(self, now_s: float) -> None:
        """Devices and disk: what is lost pauses the session, and a press under way is interrupted."""
        lost = next((stream for stream in (self._emg, self._force) if stream.lost_why), None)
        trouble = self._record.trouble
        if lost is not None and self._paused != "device":
            self._interrupt(now_s, f"{lost.view(now_s).name} lost")
            self._pause("device")
            self._say(lost.view(now_s).text)
        elif lost is None and trouble and self._paused not in ("device", "disk"):
            self._interrupt(now_s, "the disk does not take the recording")
            self._pause("disk")
            self._say(trouble)
        elif self._paused == "disk" and not trouble:
            self._go_on()
        epochs = (self._emg.epoch, self._force.epoch)
        if epochs != self._epochs and lost is None:
            self._epochs = epochs
            self._begin_stay()

    def _interrupt(self, now_s: float, why: str) -> None:
        if self._measuring is not None:
            self._measuring = None
        if (attempt := self._cycle.give_up(now_s, "interrupted", why)) is not None:
            self._over(attempt)

    def _open_or_close(self, now_s: float) -> None:
        """Presses are possible while the specimen is there, everything is confirmed, and nothing pauses."""
        cycle = self._cycle
        if cycle.attempt is not None or cycle.command == "stop":
            return
        wanted = self._wanted
        here = self._placed and wanted is not None and self._stay is not None and wanted.stay == self._stay.stay
        ready = here and self._quality_done and not self._paused and now_s >= self._pause_until_s
        cycle.hold = bool(
            self._asked or self._judge_at_s is not None or self.presses.undecided or not self._all_checked
        )
        if ready:
            if cycle.command not in ("rest", "ready"):
                cycle.open(now_s, self._settings.rest_s)
        else:
            cycle.close(self._closed(now_s))

    def _closed(self, now_s: float) -> Command:
        if self._measuring is not None:
            return "start" if self._measuring.step == "contraction" else "wait"
        if self._wanted is None and self._quality_done and not self.presses.undecided and self._judge_at_s is None:
            return "done"
        return "pause" if self._paused or now_s < self._pause_until_s else "wait"

    @property
    def _wanted(self) -> PlannedPress | None:
        """The press that comes next: of the plan, or one that is suggested on the specimen on the table."""
        return self._suggested or self.presses.next

    @property
    def _all_checked(self) -> bool:
        return all(self._checked.values())

    # a press

    def _press_begun(self, attempt: Attempt) -> None:
        """START was given, or the participant did not wait for it."""
        press = self._wanted
        assert press is not None
        if press is self._suggested:
            self._suggested = None
            why = self._fits[press.specimen].suggestion
            self._write(
                journal.PressAdded(press.number, press.phase, press.specimen, press.repetition, press.stay, why)
            )
        number = self.presses.attempts(press) + 1
        self._write(
            journal.PressBegun(press.number, number, press.specimen, press.phase, press.repetition, press.stay),
            attempt.start_s,
        )
        self._running = self.presses.find(press.number, number)
        self._lost_at_start = (self._emg.lost_samples, self._force.lost_samples)
        self._screens = [self._screen] if self._screen is not None and self._screen.hidden else []

    def _over(self, attempt: Attempt) -> None:
        """An attempt has ended: a complete one is judged once the rest after it has come."""
        tried, self._running = self._running, None
        if tried is None:
            return
        tried.times, tried.epochs = attempt, self._epochs
        assert attempt.end_s is not None
        complete = attempt.ending in ("lifted", "released")
        begun_s = attempt.start_s if attempt.begun_s is None else attempt.begun_s
        peak_n = round(attempt.peak_n, 4)
        how = "complete" if complete else "aborted"
        self._write(journal.PressEnded(tried.press.number, tried.attempt, begun_s, attempt.end_s, how, peak_n))  # type: ignore[arg-type]
        tried.around = self._circumstances(attempt)
        if self._settings.check_each_press and self._checked:
            self._checked[next(iter(self._checked))] = False
        if complete:
            self._judge_at_s = self._now_s + SETTLE_S
        else:
            self._tell_verdict(tried, StayJudged())

    def _circumstances(self, attempt: Attempt) -> Circumstances:
        assert attempt.end_s is not None
        lasted_s = max(attempt.end_s - attempt.start_s, TURN_S)
        streams = (self._emg, self._force)
        lost = (now.lost_samples - then for now, then in zip(streams, self._lost_at_start, strict=True))
        share = max(n / (lasted_s * own.info.fs_hz) for n, own in zip(lost, streams, strict=True))
        ages = [screen.age_p95_ms for screen in self._screens]
        return Circumstances(max(share, 0.0), max(ages, default=None), any(screen.hidden for screen in self._screens))

    def _work(self, now_s: float) -> None:
        """What waits for a time, or for the judge."""
        if now_s >= self._next_feed_s:
            self._next_feed_s = now_s + FEED_S
            for stream in self._feeding:
                self._flush(stream)
        if self._measuring is not None and now_s >= self._measuring.until_s:
            self._measured_now(self._measuring)
        if self._judge_at_s is not None and now_s >= self._judge_at_s and not self._asked:
            self._judge_at_s = None
            self._ask_judge()
        if self._asked and (answer := self._judge.answer()) is not None:
            asked, self._asked = self._asked, ""
            if isinstance(answer, StayJudged):
                self._take_verdicts(answer) if asked == "stay" else self._say(answer.failed)
            else:
                self._take_signals(asked, answer)
        if now_s >= self._next_clock_s:
            self._next_clock_s = now_s + CLOCK_TOLD_S
            if now_s > 0:
                self._emg.tell_clock()
                self._force.tell_clock()
        overdue = self._cycle.overdue_s(now_s) > 0
        if overdue and not self._overdue:
            self._say("The finger has not been lifted. Tell the participant to lift it, or abort the press.")
        self._overdue = overdue

    def _ask_judge(self) -> None:
        for stream in self._feeding:
            self._flush(stream)
        timing = {
            own.name: Timing(first, *own.timing(first))
            for own, first in ((own, self._stay_first[own.name]) for own in (self._emg, self._force))
        }
        self._judge.tell(JudgeStay(timing))
        self._asked = "stay"

    def _take_verdicts(self, judged: StayJudged) -> None:
        """Of the press that has ended, and of those before it: a stay is judged as a whole, as its recording will be."""
        self._judged = judged
        if self._stay is None:
            return
        for tried in self.presses.of_stay(self._stay.stay):
            if tried.complete and tried.times is not None and tried.epochs == self._epochs:
                self._tell_verdict(tried, judged)
        for said, do in judged.remarks:
            self._say(f"{said} -> {do}" if do else said)
        self._renew_fits()

    def _tell_verdict(self, tried: Tried, stay: StayJudged) -> None:
        assert tried.times is not None
        assert tried.times.end_s is not None
        judged = judge_attempt(tried.times, stay, tried.around, self._settings, self._how(tried.press.specimen).window)
        tried.found = judged.found
        event = judged_event(tried, judged)
        if not tried.verdict:
            self.verdict_delays_s.append(self._now_s - tried.times.end_s)
        if not said_the_same(event, tried):
            self._write(event)

    def _renew_fits(self) -> None:
        """Of the specimens whose presses are done; what would be suggested then."""
        assert self._stay is not None
        specimen = self._stay.specimen
        self._suggested = None
        if self._stay.phase != "main" or not self.presses.done(specimen):
            return
        own = [tried for tried in self.presses.tried if tried.press.specimen == specimen]
        found = [press for tried in own if (press := tried.usable) is not None]
        all_presses = [press for press in self.presses.presses if (press.phase, press.specimen) == ("main", specimen)]
        fit = specimen_fit(specimen, found, self._study.fit.confidence, self._settings, len(all_presses))
        if fit is None:
            return
        new = self._fits.get(specimen) != fit
        self._fits[specimen] = fit
        if fit.suggestion and specimen not in self._declined:
            number = max(press.number for press in self.presses.presses) + 1
            repetition = max(press.repetition for press in all_presses) + 1
            self._suggested = PlannedPress(number, "main", specimen, repetition, self._stay.stay)
            if new:
                self._write(journal.Told(f"{specimen}: {fit.suggestion}"))

    # before the first press

    def _measure(self, step: str) -> None:
        seconds = quality.REST_S if step == "rest" else quality.CONTRACTION_S
        if step == "rest":
            self._begin_stay()
            self._measured = {}
        self._measuring = _Measurement(step, self._now_s + seconds, self._emg.next_index)

    def _measured_now(self, measuring: _Measurement) -> None:
        self._measuring = None
        self._measured[measuring.step] = (measuring.first, self._emg.next_index)
        for stream in self._feeding:
            self._flush(stream)
        info = self._emg.info
        self._judge.tell(
            MeasureSignals(
                self._measured.get("rest"), self._measured.get("contraction"), info.fs_hz, self._study.filters,
                info.range_max,
            )
        )  # fmt: skip
        self._asked = measuring.step

    def _take_signals(self, step: str, signals: tuple[SignalView, ...]) -> None:
        self._signals = signals
        levels = {
            view.muscle: level
            for view in signals
            if (level := view.rest_v if step == "rest" else view.contraction_v) is not None
        }
        problems = tuple(problem for view in signals for problem in view.problems)
        self._write(journal.QualityMeasured("rest" if step == "rest" else "contraction", levels, problems))
        if step == "contraction":
            self._quality_done = True

    def _how(self, specimen: str) -> HowJudged:
        """The settings by which `emg2vsa check` judges the recording; training is judged as the other specimens are."""
        own = [entry for entry in self._study.recordings if entry.participant == self.participant]
        entry = next((entry for entry in own if entry.specimen == specimen), own[0])
        return HowJudged(entry.filters, entry.window, entry.channels.force, self._study.fit)

    # specimens

    def _begin_stay(self) -> None:
        """What the judge knows of the stay begins now."""
        for stream in self._feeding:
            self._flush(stream)
        specimen = "" if self._stay is None else self._stay.specimen
        columns = {muscle: at for at, muscle in enumerate(self._muscles)}
        self._judge.tell(Begin(self.participant, specimen, self._how(specimen), columns))
        self._stay_first = {own.name: own.next_index for own in (self._emg, self._force)}
        self._judged = StayJudged()

    def _place(self) -> None:
        press = self._wanted
        assert press is not None
        self._stay, self._placed = press, True
        self._bar.zero_n = self._mean_force()
        self._write(journal.Checked("specimen placed", press.specimen))
        self._begin_stay()

    def _mean_force(self) -> float:
        return float(np.nanmean(np.concatenate([newton for _, newton in self._recent])))

    def _leave(self) -> None:
        """The presses of this stay are done: the next specimen, after a break, with a new checklist."""
        if self._stay is None or self._asked or self._judge_at_s is not None or self._cycle.attempt is not None:
            return
        wanted = self._wanted
        if self._placed and (wanted is None or wanted.stay != self._stay.stay):
            self._placed = False
            self._checked = dict.fromkeys(self._settings.checklist, False)
            self._emg.tell_clock()
            self._force.tell_clock()
            if wanted is not None:
                self._pause_until_s = self._now_s + self._settings.pause_s
                self._write(journal.Paused("between specimens"))

    # pauses and the end

    def _pause(self, why: str) -> None:
        self._paused = why
        self._write(journal.Paused(why))

    def _go_on(self) -> None:
        self._paused = ""
        self._write(journal.Continued())

    def end(self, how: str = "ended", why: str = "") -> None:
        """End the session now; a press under way is interrupted."""
        with self._lock:
            if self.ended is not None:
                return
            self._interrupt(self._now_s, why or "the session was ended")
            if how == "ended" and self._wanted is None and self.presses.undecided is None:
                how = "completed"
            self._cycle.close("done")
            self.ended = journal.Ended(how, why)  # type: ignore[arg-type]
            for stream in (self._emg, self._force):
                stream.close()
            self._write(self.ended)
            self._show(self._now_s)
            self._judge.close()

    # what is asked

    def ask(self, request: Request) -> str:
        """Take a command: "" when taken, else why not, in a sentence."""
        with self._lock:
            refusal = self._refusal(request)
            if refusal:
                return refusal
            self._do(request)
            self._changed = True
            return ""

    def _refusal(self, request: Request) -> str:
        if self.ended is not None:
            return "The session has ended."
        match request.name:
            case "measure-rest" | "measure-contraction":
                return self._refuses_measuring(request.name)
            case "check":
                known = ", ".join(self._checked)
                return "" if request.item in self._checked else f"The checklist has no {request.item!r}, but: {known}."
            case "placed":
                return self._refuses_placing()
            case "start":
                return self._refuses_start()
            case "abort":
                return "" if self._cycle.attempt is not None else "No press is under way."
            case "accept" | "repeat" | "skip":
                return self._refuses_decision(request)
            case "note":
                return "" if request.text.strip() else "The note is empty."
            case "pause":
                if self._paused:
                    return "The session is paused already."
                return "A press is under way; abort it first." if self._busy else ""
            case "continue":
                return self._refuses_continuing()
            case "end":
                return "A press is under way; abort it first." if self._busy else ""
        return f"There is no command {request.name!r}."

    @property
    def _busy(self) -> bool:
        return self._cycle.attempt is not None

    def _refuses_measuring(self, name: str) -> str:
        if self._busy or self._asked or self._judge_at_s is not None:
            return "A press is under way, or being judged."
        if self._measuring is not None:
            return "A measurement is under way."
        if self._placed and name == "measure-rest":
            return "The signals are measured before a specimen is placed."
        if self._lost:
            return "A device is lost."
        return "Measure the rest first." if name == "measure-contraction" and "rest" not in self._measured else ""

    @property
    def _lost(self) -> bool:
        return bool(self._emg.lost_why or self._force.lost_why)

    def _refuses_placing(self) -> str:
        if not self._quality_done:
            return "Measure the signals at rest and at maximum contraction first, or continue without."
        if self._busy or self._asked or self._judge_at_s is not None:
            return "A press is under way, or being judged."
        if self._wanted is None:
            return "No press is left."
        if self._lost or not self._recent:
            return "The force sensor sends nothing."
        newton = np.concatenate([newton for _, newton in self._recent])
        size = max(1, newton.size // 10)
        means = newton[: newton.size // size * size].reshape(-1, size).mean(axis=1)
        if not np.isfinite(means).all() or float(np.ptp(means)) > STEADY_N:
            return "The force is not steady. Take all hands off the specimen."
        return ""

    def _refuses_start(self) -> str:
        if self._paused:
            return "The session is paused; continue first."
        if self._asked or self._judge_at_s is not None:
            return "The last press is being judged."
        if (tried := self.presses.undecided) is not None:
            return f"Press {tried.press.number} was rejected: repeat, accept or skip it first."
        wanted = self._wanted
        if wanted is None:
            return "No press is left."
        if not self._placed or self._stay is None or wanted.stay != self._stay.stay:
            return f"Place specimen {wanted.specimen} first."
        if not self._all_checked:
            return f"Confirm first: {', '.join(item for item, done in self._checked.items() if not done)}."
        if self._now_s < self._pause_until_s:
            return f"The break lasts {self._pause_until_s - self._now_s:.0f} s longer."
        return self._cycle.refuses_start(self._now_s, self._bar.force_n)

    def _refuses_decision(self, request: Request) -> str:
        tried = self._meant(request)
        if tried is None and request.name == "skip":
            return (
                "" if self._placed and self._wanted is not None and not self._busy else "No press can be skipped now."
            )
        if tried is None or not tried.over:
            return "There is no finished press to decide on."
        number = tried.press.number
        if self._asked or self._judge_at_s is not None:
            return "The last press is being judged."
        if not tried.complete:
            return "" if request.name == "skip" else f"Press {number} was not complete; it is repeated anyway."
        if request.name == "repeat":
            if self._busy:
                return "A press is under way."
            if self._stay is None or not self._placed or tried.press.stay != self._stay.stay:
                return f"Specimen {tried.press.specimen} is no longer on the table."
            if tried.verdict == "ok" and not (tried.note or request.text.strip()):
                return f"Press {number} is well done. To repeat it, give the reason as a note."
            if self.presses.repeats(tried.press) >= self._settings.most_repeats:
                most = self._settings.most_repeats
                return f"{most} presses on this specimen were repeated, which is the most: accept or skip it."
        return ""

    def _refuses_continuing(self) -> str:
        if self._paused == "device" and self._lost:
            return "The device is still lost."
        if self._paused == "disk":
            return "The disk does not take the recording. Free some disk space."
        if self._paused or self._suggested is not None:
            return ""
        return "" if not self._quality_done and self._measuring is None and not self._asked else "Nothing is paused."

    def _meant(self, request: Request) -> Tried | None:
        """The press that a decision is about: the one that is named, the undecided one, or the last."""
        if request.press is not None:
            return self.presses.find(request.press)
        over = [tried for tried in self.presses.tried if tried.over]
        return self.presses.undecided or (over[-1] if over and request.name != "skip" else None)

    def _do(self, request: Request) -> None:
        match request.name:
            case "measure-rest" | "measure-contraction":
                self._measure(request.name.removeprefix("measure-"))
            case "check":
                self._checked[request.item] = not self._checked[request.item]
                if self._checked[request.item]:
                    self._write(journal.Checked(request.item, self._wanted.specimen if self._wanted else ""))
            case "placed":
                self._place()
            case "start":
                self._cycle.start(self._now_s, self._mean_force() - self._bar.zero_n)
                self._bar.restart_peak()
                assert self._cycle.attempt is not None
                self._press_begun(self._cycle.attempt)
            case "abort":
                if (attempt := self._cycle.give_up(self._now_s, "aborted", "")) is not None:
                    self._over(attempt)
            case "accept" | "repeat" | "skip":
                self._decide(request)
            case "note":
                tried = self._meant(request)
                press, attempt_number = (tried.press.number, tried.attempt) if tried else (0, 0)
                self._write(journal.Noted(request.text.strip(), press, attempt_number))
            case "pause":
                self._pause("operator")
            case "continue":
                self._continue()
            case "end":
                self._closing = "ended"

    def _decide(self, request: Request) -> None:
        tried = self._meant(request)
        if tried is None:  # a press that is not begun is skipped
            press = self._wanted
            assert press is not None
            if press is self._suggested:
                self._declined.add(press.specimen)
                self._suggested = None
                return
            number = self.presses.attempts(press) + 1
            self._write(
                journal.PressBegun(press.number, number, press.specimen, press.phase, press.repetition, press.stay)
            )
            self._write(journal.PressEnded(press.number, number, self._now_s, self._now_s, "aborted"))
            tried = self.presses.find(press.number, number)
            assert tried is not None
        decision: journal.Decision = request.name  # type: ignore[assignment]
        if request.text.strip():
            self._write(journal.Noted(request.text.strip(), tried.press.number, tried.attempt))
        self._write(journal.Decided(tried.press.number, tried.attempt, decision, "operator", request.text.strip()))
        if self._stay is not None:
            self._renew_fits()

    def _continue(self) -> None:
        if self._paused:
            self._go_on()
        elif self._suggested is not None:
            self._write(journal.Told(f"{self._suggested.specimen}: the operator goes on without a further press."))
            self._declined.add(self._suggested.specimen)
            self._suggested = None
        else:
            self._write(journal.Told("The session begins without a measurement of the signal quality."))
            self._quality_done = True

    def screen(self, report: ScreenReport) -> None:
        """What the participant's page says of itself: kept with the press, and in the journal when it is news."""
        with self._lock:
            if self.ended is not None:
                return
            before, self._screen = self._screen, report
            if self._running is not None:
                self._screens.append(report)
            news = before is None or before.hidden != report.hidden
            if report.hidden and news:
                self._say("The participant's page is hidden. Bring it to the front, full screen.")
            if news or self._now_s - self._screen_told_s >= SCREEN_TOLD_S:
                self._screen_told_s = self._now_s
                self._write(
                    journal.ScreenTold(
                        report.frames_per_s, report.age_p50_ms, report.age_p95_ms, report.longest_frame_ms,
                        report.hidden, report.more,
                    )
                )  # fmt: skip

    # what is told

    def _begin(self, changes: tuple[str, ...]) -> None:
        plan = self._record.plan
        self._write(
            journal.Begun(
                plan.participant, plan.study, f"emg2vsa {__version__}", platform.platform(), self._settings.ethics,
                self._record.sitting > 1, changes,
            )
        )  # fmt: skip
        for change in changes:
            self._say(f"The study file has changed since the session began: {change}. The order stays.")

    def _write(self, event: journal.Event, time_s: float | None = None) -> None:
        self._record.append(event, self._now_s if time_s is None else time_s)
        self.presses.take(event)
        self._changed = True

    def _say(self, text: str) -> None:
        if text and text not in self._said:
            self._said.append(text)
            self._write(journal.Told(text))

    def _show(self, now_s: float) -> None:
        self._leave()
        if self._closing and self.ended is None:
            self._closing = ""
            self.end()
            return
        cycle = self._cycle
        if cycle.command != self._command:
            self._command = cycle.command
            about = self._running
            press, attempt = (about.press.number, about.attempt) if about else (0, 0)
            self._write(journal.Commanded(cycle.command, press, attempt))
        self._sequence += 1
        force_n = self._bar.force_n
        speed = cycle.speed(now_s, force_n)
        newest_s = getattr(self, "_newest_force_s", now_s)
        self.force_message = ForceMessage(
            self._sequence, newest_s, round(force_n, 4), self._bar.direction, speed, cycle.command
        )
        self.traces.turn(now_s, force_n)
        if self._changed or now_s >= self._next_state_s:
            self._changed = False
            self._next_state_s = now_s + STATE_S
            self.participant_state = self._participant_state()
            number, before = self.operator_state
            state = self._operator_state()
            if state != before:
                self.operator_state = (number + 1, state)

    def _participant_state(self) -> ParticipantState:
        own, wanted = self._settings, self._running.press if self._running else self._wanted
        texts = {name: value for name, value in vars(own.texts).items() if name != "language"}
        command = self._cycle.command
        text = texts.get(command, own.texts.wait)
        if self._measuring is not None:
            text = own.texts.contract if self._measuring.step == "contraction" else own.texts.relax
        place, of = (0, 0) if wanted is None else self.presses.place(wanted) if wanted is not self._suggested else (
            self.presses.place(self._stay)[1] + 1, self.presses.place(self._stay)[1] + 1,  # type: ignore[arg-type]
        )  # fmt: skip
        phase = "quality" if not self._quality_done else "main" if wanted is None else wanted.phase
        until_s = self._pause_until_s if command == "pause" and self._now_s < self._pause_until_s else None
        return ParticipantState(
            command, text, phase, place, of, own.force_n, own.bar_n, own.load_s, own.palette, own.sound,
            own.texts.language, texts, until_s,
        )  # type: ignore[arg-type]  # fmt: skip

    def _awaits(self) -> tuple[str, str]:
        """What the operator is to do now, and the same in a sentence."""
        wanted = self._wanted
        if self.ended is not None:
            return "", "The session has ended."
        if self._measuring is not None:
            return "", f"The {self._measuring.step} is being measured."
        if self._paused:
            return "", {"device": "A device is lost.", "disk": "The disk is full."}.get(self._paused, "Paused.")
        if not self._quality_done:
            if "rest" not in self._measured:
                return "quality", "Ask the participant to relax the arm, then measure the rest."
            return "contraction", "Ask the participant to tense the forearm for 3 s, then measure."
        if self._busy or self._asked or self._judge_at_s is not None:
            return "", "A press is under way." if self._busy else "The press is being judged."
        if (tried := self.presses.undecided) is not None:
            return "verdict", f"Press {tried.press.number} is rejected: repeat, accept or skip it."
        if wanted is None:
            return "end", "Every press is done. End the session."
        if not self._placed:
            return "specimen", f"Place specimen {wanted.specimen}. Nobody may touch it when you confirm."
        if not self._all_checked:
            return "checklist", "Confirm the checklist."
        if wanted is self._suggested:
            return "start", f"{self._fits[wanted.specimen].suggestion} START for one more, or continue without."
        if self._now_s < self._pause_until_s:
            return "", f"Break: {self._pause_until_s - self._now_s:.0f} s."
        return "start", f"Press {wanted.number} on {wanted.specimen}: give START."

    def _operator_state(self) -> OperatorState:
        awaits, message = self._awaits()
        wanted = self._running.press if self._running else self._wanted
        now_s = self._now_s
        names = (
            "measure-rest", "measure-contraction", "placed", "start", "abort", "accept", "repeat", "skip", "pause",
            "continue", "end",
        )  # fmt: skip
        possible = [name for name in names if not self._refusal(Request(name))] + ["check", "note"]
        running = self._running.view() if self._running else None
        safe = "everything is on the disk" if self._record.is_safe else "the disk is behind"
        return OperatorState(
            participant=self.participant,
            study=self._study.title or self._study.name,
            command=self._cycle.command,
            awaits=awaits,
            message=message,
            specimen="" if wanted is None else wanted.specimen,
            phase="quality" if not self._quality_done else "main" if wanted is None else wanted.phase,
            press=running,
            presses=self.presses.views(),
            checklist=dict(self._checked),
            devices=(self._emg.view(now_s), self._force.view(now_s)),
            signals=self._signals,
            fits=tuple(self._fits.values()),
            warnings=tuple(self._said),
            commands=tuple(possible) if self.ended is None else (),
            saved=f"{self._record.folder}: {self._record.lines} events; {self._record.trouble or safe}.",
            ended="" if self.ended is None else f"{self.ended.how}{': ' if self.ended.why else ''}{self.ended.why}",
        )


def check_muscles(study: Study, channels: tuple[str, ...]) -> None:
    """SettingError where the source of the EMG has no channel for a muscle of the study."""
    missing = [muscle for muscle in study.recordings[0].channels.emg if muscle not in channels]
    if missing:
        raise SettingError(
            f"{study.path}, session.emg.channels", wanted=f"a channel for {', '.join(missing)}",
            found=f"channels {', '.join(channels)}", do="Name the source's channel of every muscle in [channels.emg].",
        )  # fmt: skip


def run_session(session: Session, clock: Clock, beside: Callable[[float], None] = lambda now_s: None) -> None:
    """Turn until the session has ended. beside : called after each turn, as by an emulated operator."""
    beat = Beat(clock, TURN_S)
    while session.ended is None:
        now_s, _ = beat.wait()
        session.turn(now_s)
        beside(now_s)
