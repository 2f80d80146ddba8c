"""One participant's session: 200 turns a second from the samples that have come to what the pages show.

A turn reads the sources (whose samples go to the disk first), filters the bar's force, moves the command on, hands what
has come to the judge, writes what happened into the journal, and renews the views. What the operator asks for is taken
between two turns, from any thread.
"""

from __future__ import annotations

import platform
import threading
from collections import deque
from dataclasses import dataclass

import numpy as np

from emg2vsa import __version__
from emg2vsa.arrays import Floats
from emg2vsa.errors import SettingError
from emg2vsa.session import journal, quality
from emg2vsa.session.bar_force import BarForce
from emg2vsa.session.judge_feed import JudgeFeed
from emg2vsa.session.live_fit import specimen_fit
from emg2vsa.session.live_press import Circumstances, HowJudged, StayJudged, judge_attempt
from emg2vsa.session.plan import PlannedPress
from emg2vsa.session.press_cycle import LIFTED_S, Attempt, PressCycle
from emg2vsa.session.press_list import PressList, Tried, judged_event
from emg2vsa.session.record import SessionRecord
from emg2vsa.session.recorded_stream import Arrived, RecordedStream
from emg2vsa.session.stay_judge import Judge
from emg2vsa.session.traces import Traces
from emg2vsa.session.views import (
    Command,
    ForceMessage,
    ScreenReport,
    SignalView,
    SpecimenFit,
)
from emg2vsa.session_settings import SessionSettings
from emg2vsa.study import Study

TURN_S = 0.005
SETTLE_S = 0.5
"A press is judged with so much of the rest after it, without which its filters would end within it."
JUDGED_VALUES = 240_000
"The end of a stay with so many samples, over all muscles, is judged within a second."
ZERO_S = 0.5
"The zero of force is the mean over this time."
WRONG_SIGN = (
    "The force falls while the specimen is pressed: its sign is wrong. End the session, turn the sign of "
    "session.force.axis (or of the stream that is sent) round, and resume."
)
CLOCK_TOLD_S, SCREEN_TOLD_S = 60.0, 10.0
"How often the clocks of the devices, and a screen without news, are told to the journal."
SCREEN_NEWS_S = 1.0
"A screen with news is told no more often."
MENDED_S = 0.9
"A press after a rejected one is judged from so long before its START: what was wrong has been mended by then."
LAST_LINES_S = 2.0
"At the end the disk has so long to take the last lines before the page shows how the session ended."
_MOST_WARNINGS = 8


@dataclass(frozen=True)
class _Measurement:
    step: str
    until_s: float
    first: int


class Session:
    """A session between its sources, its record and its pages.

    ``turn`` belongs to one thread. Who changes or reads more than one value from another holds ``lock``.
    """

    def __init__(
        self,
        study: Study,
        settings: SessionSettings,
        record: SessionRecord,
        streams: tuple[RecordedStream, RecordedStream],
        judge: Judge,
        now_s: float,
        changes: tuple[str, ...] = (),
    ) -> None:
        """streams : of EMG and force, open. judge : closed by the session. changes : of the study file on resume."""
        self.study, self.settings, self.record = study, settings, record
        self.emg, self.force = streams
        self.lock = threading.RLock()
        self.now_s = now_s
        self._muscles = tuple(study.recordings[0].channels.emg)
        self.participant = record.plan.participant
        self.bar = BarForce(settings.bar_filter_hz)
        self.cycle = PressCycle(settings, study.window.max_duration_s)
        self.presses = PressList(record.progress)
        for line in record.past:
            self.presses.take(line.event)
        self.traces = Traces(self._muscles)
        self.recent: deque[tuple[float, Floats]] = deque()
        self.judge = JudgeFeed(judge, streams, self._muscles)
        self._newest_force_s = now_s
        # of the time before the first press
        self.measuring: _Measurement | None = None
        self.measured: dict[str, tuple[int, int]] = {}
        self.signals: tuple[SignalView, ...] = ()
        self.quality_done = False
        # of the specimen on the table
        self.stay: PlannedPress | None = None
        self.placed = False
        self.checklist = dict.fromkeys(settings.checklist, False)
        self._epochs = (0, 0)
        self.pause_until_s = 0.0
        self.paused = ""
        self._judge_at_s: float | None = None
        self._asked_of: tuple[Tried, ...] = ()
        self._writing: deque[tuple[int, journal.Judged, float]] = deque()
        "Verdicts that are not on the disk itself, which no page shows: line, event, end of the press."
        self.suggested: PlannedPress | None = None
        self.declined: set[str] = set()
        self.fits: dict[str, SpecimenFit] = {}
        # of the attempt that runs
        self.running: Tried | None = None
        self._lost_at_start: tuple[int, int] = (0, 0)
        self._screens: list[ScreenReport] = []
        self._screen: ScreenReport | None = None
        self._screen_told_s = -SCREEN_TOLD_S
        self._screen_news = False
        self.verdict_delays_s: list[float] = []
        "From the end of each press to its verdict."
        # what is shown
        self.warnings: deque[str] = deque(maxlen=_MOST_WARNINGS)
        self._message = ""
        self._sequence = 0
        self._next_clock_s = 0.0
        self._overdue = False
        self._command: Command = "wait"
        self.closing = ""
        self.ended: journal.Ended | None = None
        self.force_message = ForceMessage(0, 0.0, 0.0, "none", "", "wait")
        self.changes = 0
        "Counts what happened, for whoever shows it."
        self._begin(changes)

    # the turn

    def turn(self, now_s: float) -> None:
        """Everything that has come until now, and everything that follows from it."""
        with self.lock:
            self.now_s = now_s
            for arrived in self.force.read(now_s):
                self._take_force(arrived)
            for arrived in self.emg.read(now_s):
                self._take_emg(arrived)
            self._watch(now_s)
            self._open_or_close(now_s)
            between = self.cycle.between
            if (attempt := self.cycle.turn(now_s, self.bar.force_n)) is not None:
                self.over(attempt)
            elif self.cycle.between and not between:
                self._say(
                    "The specimen was pressed between presses. It counts as no press. Ask to wait for START.",
                    again=True,
                )
            elif self.cycle.attempt is not None and self.running is None:
                self.press_begun(self.cycle.attempt)
            self._work(now_s)
            self._show(now_s)

    def _take_force(self, arrived: Arrived) -> None:
        newton = arrived.samples[:, 0]
        self.bar.take(newton, self.force.info.fs_hz, arrived.newest_s)
        self._newest_force_s = arrived.newest_s
        self.recent.append((self.now_s, newton))
        while self.recent and self.recent[0][0] < self.now_s - ZERO_S:
            self.recent.popleft()
        self.judge.take("force", arrived)

    def _take_emg(self, arrived: Arrived) -> None:
        columns = [self.emg.info.channels.index(muscle) for muscle in self._muscles]
        self.traces.emg(arrived.samples[:, columns], self.emg.info.fs_hz)
        self.judge.take("emg", arrived._replace(samples=arrived.samples[:, columns]))

    def _watch(self, now_s: float) -> None:
        """Devices and disk: what is lost pauses the session, and a press under way is interrupted."""
        lost = next((stream for stream in (self.emg, self.force) if stream.lost_why), None)
        trouble = self.record.trouble
        if lost is not None and self.paused != "device":
            self._interrupt(now_s, f"{lost.view(now_s).name} lost")
            self.pause("device")
            self._say(lost.view(now_s).text)
        elif lost is None and trouble and self.paused not in ("device", "disk"):
            self._interrupt(now_s, "the disk does not take the recording")
            self.pause("disk")
            self._say(trouble)
        elif self.paused == "disk" and not trouble:
            self.go_on()
        epochs = (self.emg.epoch, self.force.epoch)
        if epochs != self._epochs and lost is None:
            self._epochs = epochs
            self._begin_stay()

    def _interrupt(self, now_s: float, why: str) -> None:
        self.measuring = None
        if (attempt := self.cycle.give_up(now_s, "interrupted", why)) is not None:
            self.over(attempt)

    def _open_or_close(self, now_s: float) -> None:
        """Presses are possible while the specimen is there, everything is confirmed, and nothing pauses."""
        cycle = self.cycle
        if cycle.attempt is not None or cycle.command == "stop":
            return
        wanted = self.wanted
        here = self.placed and wanted is not None and self.stay is not None and wanted.stay == self.stay.stay
        ready = here and self.quality_done and not self.paused and now_s >= self.pause_until_s
        cycle.hold = bool(self.judging or self.presses.undecided or not self.all_checked)
        if ready:
            if cycle.command not in ("rest", "ready"):
                cycle.open(now_s, self.settings.rest_s)
        else:
            cycle.close(self._closed(now_s))

    def _closed(self, now_s: float) -> Command:
        if self.wanted is None and self.quality_done and not self.presses.undecided and not self.judging:
            return "done"
        return "pause" if self.paused or now_s < self.pause_until_s else "wait"

    @property
    def command(self) -> Command:
        """What the participant is told; a contraction begins with START as a press does."""
        contracting = self.measuring is not None and self.measuring.step == "contraction"
        return "start" if contracting else self.cycle.command

    @property
    def wanted(self) -> PlannedPress | None:
        """The press that comes next: of the plan, or one that is suggested on the specimen on the table."""
        return self.suggested or self.presses.next

    @property
    def busy(self) -> bool:
        """Whether a press is under way."""
        return self.cycle.attempt is not None

    @property
    def lost(self) -> bool:
        """Whether a device is."""
        return bool(self.emg.lost_why or self.force.lost_why)

    @property
    def judging(self) -> bool:
        """Whether a press, or the signal quality, waits for its judge, or a verdict for the disk."""
        return bool(self.judge.asked) or self._judge_at_s is not None or self.writing

    @property
    def writing(self) -> bool:
        """Whether a verdict is on its way to the disk."""
        return bool(self._writing)

    @property
    def all_checked(self) -> bool:
        return all(self.checklist.values())

    # a press

    def press_begun(self, attempt: Attempt) -> None:
        """START was given, or the participant did not wait for it."""
        press = self.wanted
        assert press is not None
        if press is self.suggested:
            self.suggested = None
            why = self.fits[press.specimen].suggestion
            self.write(journal.PressAdded(press.number, press.phase, press.specimen, press.repetition, press.stay, why))
        number = self.presses.attempts(press) + 1
        self.write(
            journal.PressBegun(press.number, number, press.specimen, press.phase, press.repetition, press.stay),
            attempt.start_s,
        )
        self.running = self.presses.find(press.number, number)
        self._lost_at_start = (self.emg.lost_samples, self.force.lost_samples)
        self._screens = [self._screen] if self._screen is not None and self._screen.hidden else []

    def over(self, attempt: Attempt) -> None:
        """An attempt has ended: a complete one is judged once the rest after it has come."""
        tried, self.running = self.running, None
        if tried is None:
            return
        tried.times, tried.epochs = attempt, self._epochs
        assert attempt.end_s is not None
        complete = attempt.ending in ("lifted", "released")
        begun_s = attempt.start_s if attempt.begun_s is None else attempt.begun_s
        peak_n = round(attempt.peak_n, 4)
        how = "complete" if complete else "aborted"
        self.write(journal.PressEnded(tried.press.number, tried.attempt, begun_s, attempt.end_s, how, peak_n))  # type: ignore[arg-type]
        tried.around = self._circumstances(attempt)
        if self.settings.check_each_press and self.checklist:
            self.checklist[next(iter(self.checklist))] = False
        if complete:
            self._judge_at_s = self.now_s + SETTLE_S
        else:
            self._tell_verdict(tried, StayJudged())

    def _circumstances(self, attempt: Attempt) -> Circumstances:
        assert attempt.end_s is not None
        lasted_s = max(attempt.end_s - attempt.start_s, TURN_S)
        streams = (self.emg, self.force)
        lost = (now.lost_samples - then for now, then in zip(streams, self._lost_at_start, strict=True))
        share = max(n / (lasted_s * own.info.fs_hz) for n, own in zip(lost, streams, strict=True))
        ages = [screen.age_p95_ms for screen in self._screens]
        return Circumstances(max(share, 0.0), max(ages, default=None), any(screen.hidden for screen in self._screens))

    def _work(self, now_s: float) -> None:
        """What waits for a time, or for the judge."""
        self.judge.turn(now_s)
        if self.measuring is not None and now_s >= self.measuring.until_s:
            self._measured_now(self.measuring)
        if self._judge_at_s is not None and now_s >= self._judge_at_s and not self.judge.asked:
            self._judge_at_s = None
            self._ask_judge()
        if (answered := self.judge.answer()) is not None:
            asked, answer = answered
            if isinstance(answer, StayJudged):
                self._take_verdicts(answer) if asked == "stay" else self._say(answer.failed)
            else:
                self._take_signals(asked, answer)
        self._show_written()
        if now_s >= self._next_clock_s:
            self._next_clock_s = now_s + CLOCK_TOLD_S
            if now_s > 0:
                self.emg.tell_clock()
                self.force.tell_clock()
        if self.cycle.command == "start" and self.bar.force_n <= -self.settings.force_n[0]:
            self._say(WRONG_SIGN)
        overdue = self.cycle.overdue_s(now_s) > 0
        if overdue and not self._overdue:
            self._say("The finger has not been lifted. Tell the participant to lift it, or abort the press.")
        self._overdue = overdue

    def _ask_judge(self) -> None:
        """About the press that has ended, with the stay before it, or as much of that as is judged within a second."""
        stay = -1 if self.stay is None else self.stay.stay
        self._asked_of = tuple(
            tried
            for tried in self.presses.of_stay(stay)
            if tried.complete and not tried.verdict and tried.epochs == self._epochs
        )
        self.judge.ask_stay(self._judge_from_s(JUDGED_VALUES / (len(self._muscles) * self.emg.info.fs_hz)))

    def _judge_from_s(self, longest_s: float) -> float:
        """The end of a press, after which no more than ``longest_s`` has passed; 0: all of the stay.

        What was badly done and is done again is left behind, with the rest in which its cause was mended: an electrode
        that was off once, or a channel that was clipped, is no fault of what follows.
        """
        if self.stay is None:
            return 0.0
        own = [each for each in self.presses.of_stay(self.stay.stay) if each.epochs == self._epochs and each.times]
        times = [(each.times.start_s, each.times.end_s + LIFTED_S) for each in own if each.times and each.times.end_s]
        from_s = 0.0
        for tried, (_, end_s), (next_s, _) in zip(own[:-1], times[:-1], times[1:], strict=True):
            if tried.verdict == "rejected":
                from_s = max(end_s, next_s - MENDED_S)
        if self.now_s - max(from_s, self.judge.start_s) <= longest_s:
            return from_s
        ends = [end_s for _, end_s in times[:-1]]
        return max(from_s, next((end_s for end_s in ends if self.now_s - end_s <= longest_s), max(ends, default=0.0)))

    def _take_verdicts(self, judged: StayJudged) -> None:
        """Of the press that has ended. A verdict stays: what comes later in a stay is no fault of an earlier press."""
        for tried in self._asked_of:
            self._tell_verdict(tried, judged)
        for said, do in judged.remarks:
            self._say(f"{said} -> {do}" if do else said)

    def _tell_verdict(self, tried: Tried, stay: StayJudged) -> None:
        """Write a verdict; the pages show it once it is on the disk itself."""
        assert tried.times is not None
        assert tried.times.end_s is not None
        judged = judge_attempt(tried.times, stay, tried.around, self.settings, self._how(tried.press.specimen).window)
        tried.found = judged.found
        event = judged_event(tried, judged)
        line = self.record.append(event, self.now_s)
        self._writing.append((line.number, event, tried.times.end_s))

    def _show_written(self) -> None:
        if not self._writing or self._writing[0][0] > self.record.safe_lines:
            return
        while self._writing and self._writing[0][0] <= self.record.safe_lines:
            _, event, end_s = self._writing.popleft()
            self.presses.take(event)
            self.verdict_delays_s.append(self.now_s - end_s)
        self.changes += 1
        if self.stay is not None:
            self.renew_fits()

    def renew_fits(self) -> None:
        """Of the specimens whose presses are done; what would be suggested then."""
        assert self.stay is not None
        specimen = self.stay.specimen
        self.suggested = None
        if self.stay.phase != "main" or not self.presses.done(specimen):
            return
        counting = self.record.progress.counting
        own = [tried for tried in self.presses.tried if tried.press.specimen == specimen]
        own = [tried for tried in own if counting.get(tried.press.number) == tried.attempt]
        found = [press for tried in own if (press := tried.usable) is not None]
        all_presses = [press for press in self.presses.presses if (press.phase, press.specimen) == ("main", specimen)]
        fit = specimen_fit(specimen, found, self.study.fit.confidence, self.settings, len(all_presses))
        if fit is None:
            return
        new = self.fits.get(specimen) != fit
        self.fits[specimen] = fit
        if fit.suggestion and specimen not in self.declined:
            number = max(press.number for press in self.presses.presses) + 1
            repetition = max(press.repetition for press in all_presses) + 1
            self.suggested = PlannedPress(number, "main", specimen, repetition, self.stay.stay)
            if new:
                self.write(journal.Told(f"{specimen}: {fit.suggestion}"))

    # before the first press

    def measure(self, step: str) -> None:
        seconds = quality.REST_S if step == "rest" else quality.CONTRACTION_S
        if step == "rest":
            self._begin_stay()
            self.measured = {}
        self.measuring = _Measurement(step, self.now_s + seconds, self.emg.next_index)

    def _measured_now(self, measuring: _Measurement) -> None:
        self.measuring = None
        self.measured[measuring.step] = (measuring.first, self.emg.next_index)
        self.judge.ask_signals(measuring.step, self.measured, self.study.filters)

    def _take_signals(self, step: str, signals: tuple[SignalView, ...]) -> None:
        self.signals = signals
        levels = {
            view.muscle: level
            for view in signals
            if (level := view.rest_v if step == "rest" else view.contraction_v) is not None
        }
        problems = tuple(problem for view in signals for problem in view.problems)
        self.write(journal.QualityMeasured("rest" if step == "rest" else "contraction", levels, problems))
        if step == "contraction":
            self.quality_done = True

    def _how(self, specimen: str) -> HowJudged:
        """The settings by which `emg2vsa check` judges the recording; training is judged as the other specimens are."""
        own = [entry for entry in self.study.recordings if entry.participant == self.participant]
        entry = next((entry for entry in own if entry.specimen == specimen), own[0])
        return HowJudged(entry.filters, entry.window, entry.channels.force, self.study.fit)

    # specimens

    def _begin_stay(self) -> None:
        """What the judge knows of the stay begins now."""
        specimen = "" if self.stay is None else self.stay.specimen
        self.judge.begin(self.participant, specimen, self._how(specimen))

    def place(self) -> None:
        press = self.wanted
        assert press is not None
        self.stay, self.placed = press, True
        self.bar.zero_n = self.mean_force()
        self.write(journal.Checked(journal.PLACED, press.specimen))
        self._begin_stay()

    def mean_force(self) -> float:
        return float(np.nanmean(np.concatenate([newton for _, newton in self.recent])))

    def _leave(self) -> None:
        """The presses of this stay are done: the next specimen, after a break, with a new checklist."""
        if self.stay is None or self.judging or self.cycle.attempt is not None:
            return
        wanted = self.wanted
        if self.placed and (wanted is None or wanted.stay != self.stay.stay) and not self.presses.undecided:
            self.placed = False
            self.checklist = dict.fromkeys(self.settings.checklist, False)
            self.emg.tell_clock()
            self.force.tell_clock()
            if wanted is not None:
                self.pause_until_s = self.now_s + self.settings.pause_s
                self.write(journal.Paused("between specimens"))

    # pauses and the end

    def pause(self, why: str) -> None:
        self.paused = why
        self.write(journal.Paused(why))

    def go_on(self) -> None:
        self.paused = ""
        self.write(journal.Continued())

    def end(self, how: str = "ended", why: str = "") -> None:
        """End the session now; a press under way is interrupted."""
        with self.lock:
            if self.ended is not None:
                return
            self._interrupt(self.now_s, why or "the session was ended")
            if how == "ended" and self.wanted is None and self.presses.undecided is None:
                how = "completed"
            self.cycle.close("done")
            self.ended = journal.Ended(how, why)  # type: ignore[arg-type]
            for stream in (self.emg, self.force):
                stream.close()
            self.write(self.ended)
            self.record.wait(LAST_LINES_S)
            self._show_written()
            self._show(self.now_s)
            self.judge.close()

    # what the participant's page says

    def screen(self, report: ScreenReport) -> None:
        """What the participant's page says of itself: kept with the press, and in the journal when it is news."""
        with self.lock:
            if self.ended is not None:
                return
            before, self._screen = self._screen, report
            if self.running is not None:
                self._screens.append(report)
            news = before is None or before.hidden != report.hidden
            if report.hidden and news:
                self._say("The participant's page is hidden. Bring it to the front, full screen.")
            self._screen_news |= news
            if self.now_s - self._screen_told_s >= (SCREEN_NEWS_S if self._screen_news else SCREEN_TOLD_S):
                self._screen_told_s, self._screen_news = self.now_s, False
                self.write(
                    journal.ScreenTold(
                        report.frames_per_s, report.age_p50_ms, report.age_p95_ms, report.longest_frame_ms,
                        report.hidden, report.more,
                    )
                )  # fmt: skip

    # what is told

    def _begin(self, changes: tuple[str, ...]) -> None:
        plan = self.record.plan
        self.write(
            journal.Begun(
                plan.participant, plan.study, f"emg2vsa {__version__}", platform.platform(), self.settings.ethics,
                self.record.sitting > 1, changes,
            )
        )  # fmt: skip
        for change in changes:
            self._say(f"The study file has changed since the session began: {change}. The order stays.")

    def write(self, event: journal.Event, time_s: float | None = None) -> None:
        self.record.append(event, self.now_s if time_s is None else time_s)
        self.presses.take(event)
        self.changes += 1

    def _say(self, text: str, again: bool = False) -> None:
        """again : written each time, though it is shown already."""
        shown = text in self.warnings
        if text and not shown:
            self.warnings.append(text)
        if text and (again or not shown):
            self.write(journal.Told(text))

    def _show(self, now_s: float) -> None:
        self._leave()
        if self.closing and self.ended is None:
            self.closing = ""
            self.end()
            return
        cycle = self.cycle
        if self.command != self._command:
            self._command = self.command
            about = self.running
            press, attempt = (about.press.number, about.attempt) if about else (0, 0)
            self.write(journal.Commanded(self.command, press, attempt))
        self._sequence += 1
        force_n = self.bar.force_n
        speed = cycle.speed(now_s, force_n)
        self.force_message = ForceMessage(
            self._sequence, self._newest_force_s, round(force_n, 4), self.bar.direction, speed, self.command
        )
        self.traces.turn(now_s, force_n)


def check_muscles(study: Study, channels: tuple[str, ...]) -> None:
    """SettingError where the source of the EMG has no channel for a muscle of the study."""
    missing = [muscle for muscle in study.recordings[0].channels.emg if muscle not in channels]
    if missing:
        raise SettingError(
            f"{study.path}, session.emg.channels", wanted=f"a channel for {', '.join(missing)}",
            found=f"channels {', '.join(channels)}", do="Name the source's channel of every muscle in [channels.emg].",
        )  # fmt: skip
