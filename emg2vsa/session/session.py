"""One participant's session: 200 turns a second from the samples that have come to what the pages show.

A turn reads the sources (whose samples go to the disk first), filters the bar's force, moves the command on, hands what
has come to the judge, and writes what happened into the journal; the journal's lines make the state, and the state the
views. What the operator asks for is taken between two turns, from any thread.
"""

from __future__ import annotations

import platform
import threading
from collections import deque
from collections.abc import Sequence

from emg2vsa import __version__
from emg2vsa.durable.writer import DISK_TROUBLE
from emg2vsa.errors import SettingError
from emg2vsa.session import journal, state
from emg2vsa.session.bar_force import BarForce, RecentForce
from emg2vsa.session.journal import Line
from emg2vsa.session.judge_feed import JudgeFeed, how_judged
from emg2vsa.session.legal import Now
from emg2vsa.session.live_press import StayJudged, judge_attempt
from emg2vsa.session.plugs import Plugs
from emg2vsa.session.press_cycle import Attempt, PressCycle
from emg2vsa.session.presses import Presses, Tried
from emg2vsa.session.record import SessionRecord, saved
from emg2vsa.session.recorded_stream import Arrived, RecordedStream
from emg2vsa.session.screens import HIDDEN, Screens
from emg2vsa.session.stay_judge import Judge
from emg2vsa.session.traces import LiveEnvelope, Traces
from emg2vsa.session.views import Command, ForceMessage, ScreenReport, SignalView
from emg2vsa.session_settings import SessionSettings
from emg2vsa.study import Study

TURN_S = 0.005
WRONG_SIGN = (
    "The force falls while the specimen is pressed: its sign is wrong. End the session, turn the sign of "
    "session.force.axis (or of the stream that is sent) round, and resume."
)
OVERDUE = "The finger has not been lifted. Tell the participant to lift it, or abort the press."
BETWEEN_PRESSES = "The specimen was pressed between presses. It counts as no press. Ask to wait for START."
CLOCK_TOLD_S = 60.0
"How often the clocks of the devices are told to the journal."
LAST_LINES_S = 2.0
"Time that the disk has to take the last lines before the page shows how the session ended."


class Session:
    """A session between its sources, its record and its pages.

    state : a fold over the journal; a verdict is in it once it is on the disk itself. changes : counts what happened,
    for whoever shows it. verdict_delays_s : from the end of each press to its verdict. ``turn`` belongs to one thread.
    Who changes or reads more than one value from another holds ``lock``.
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
        deviations: Sequence[str] = (),
        plugs: Plugs | None = None,
    ) -> None:
        """streams : of EMG and force, open. judge : closed by the session. changes : of the study file on resume.
        deviations : from a registered plan, in sentences. plugs : closed by who opened them."""
        self.study, self.settings, self.record = study, settings, record
        self.emg, self.force = streams
        self.lock = threading.RLock()
        self.now_s = now_s
        rules = state.Rules.of(study, record.plan.participant)
        self.state = state.begun(rules, Presses(record.plan.presses))
        self._unsafe: deque[Line] = deque()
        "Verdicts that are not on the disk itself."
        self._at_table = False
        self.bar, self.recent = BarForce(settings.bar_filter_hz), RecentForce()
        self.cycle = PressCycle(settings, study.window.max_duration_s)
        self.traces = Traces(rules.muscles)
        self.judge = JudgeFeed(judge, streams, study, rules.participant)
        self.screens, self.plugs = Screens(), plugs or Plugs()
        self.envelope = LiveEnvelope(self.emg.info.fs_hz)
        self._newest_force_s = now_s
        self._lost_at_start = (0, 0)
        self._next_clock_s = 0.0
        self._overdue = self.closing = False
        self.changes = 0
        self.verdict_delays_s: list[float] = []
        self.force_message = ForceMessage(0, 0.0, 0.0, "none", "", "wait")
        for line in record.past:
            self.state = state.after(self.state, line)
        record.follow = self._follow
        self.write(
            journal.Begun(
                rules.participant, record.plan.study, f"emg2vsa {__version__}", platform.platform(), settings.ethics,
                record.sitting > 1, changes,
            )
        )  # fmt: skip
        for change in changes:
            self._say(f"The study file has changed since the session began: {change}. The order stays.")
        for deviation in deviations:
            self._say(deviation)

    def _follow(self, line: Line) -> None:
        if isinstance(line.event, journal.Judged):
            self._unsafe.append(line)
        else:
            self.state = state.after(self.state, line)
            self._plug(line)

    def _plug(self, line: Line) -> None:
        if (sent := self.plugs.happened(line, self.state.presses)) is not None:
            self.write(*sent)

    # the turn

    def turn(self, now_s: float) -> None:
        """Everything that has come until ``now_s``, s, and everything that follows from it."""
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
                self._say(BETWEEN_PRESSES, again=True)
            elif self.cycle.attempt is not None and self.state.running is None:
                self.press_begun(self.cycle.attempt)
            self._work(now_s)
            self._show(now_s)
            self.plugs.turn(now_s)
            while self.plugs.troubles:
                self._say(self.plugs.troubles.popleft())

    def _take_force(self, arrived: Arrived) -> None:
        newton = arrived.samples[:, 0]
        self.bar.take(newton, self.force.info.fs_hz, arrived.newest_s)
        self._newest_force_s = arrived.newest_s
        self.recent.take(newton, self.now_s)
        self.plugs.force(arrived)
        self.judge.take("force", arrived)

    def _take_emg(self, arrived: Arrived) -> None:
        columns = [self.emg.info.channels.index(muscle) for muscle in self.state.rules.muscles]
        arrived = arrived._replace(samples=arrived.samples[:, columns])
        envelope_v = self.envelope.take(arrived.samples)
        self.traces.emg(arrived.samples, envelope_v)
        self.plugs.emg(arrived, envelope_v)
        self.judge.take("emg", arrived)

    def _watch(self, now_s: float) -> None:
        """Devices and disk: what is lost pauses the session, and a press under way is interrupted."""
        lost = next((stream for stream in (self.emg, self.force) if stream.lost_why), None)
        trouble, paused = self.record.trouble, self.state.paused
        if lost is not None and paused != "device":
            self._interrupt(now_s, f"{lost.view(now_s).name} lost")
            self.write(journal.Paused("device"))
            self._say(lost.view(now_s).text)
        elif lost is None and trouble and paused not in ("device", "disk") and not self._practising:
            self._interrupt(now_s, "the disk does not take the recording")
            self.write(journal.Paused("disk"))
        elif paused == "disk" and not trouble:
            self.write(journal.Continued())
        if trouble:
            self._say(trouble)
        elif any(text.startswith(DISK_TROUBLE) for text in self.state.warnings):
            self.write(journal.Told(state.DISK_BACK))
        if lost is None:
            self.judge.opened(self.state)

    @property
    def _practising(self) -> bool:
        """What comes before the presses that count goes on while the disk refuses."""
        press = self.state.running.press if self.state.running else self.state.wanted
        return not self.state.quality_done or (press is not None and press.phase == "training")

    def _interrupt(self, now_s: float, why: str) -> None:
        if (attempt := self.cycle.give_up(now_s, "interrupted", why)) is not None:
            self.over(attempt)

    def _open_or_close(self, now_s: float) -> None:
        """Presses are possible while the specimen is there, everything is confirmed, and nothing pauses."""
        cycle, own = self.cycle, self.state
        if cycle.attempt is not None or cycle.command == "stop":
            return
        pause = bool(own.paused) or now_s < own.break_until_s
        judging = own.judging or self._unsafe or self.judge.asked
        cycle.hold = bool(judging or own.presses.undecided or own.unchecked)
        if own.here and own.quality_done and not pause:
            if cycle.command not in ("rest", "ready"):
                cycle.open(now_s, self.settings.rest_s)
        elif own.wanted is None and own.quality_done and not own.presses.undecided and not judging:
            cycle.close("done")
        else:
            cycle.close("pause" if pause else "wait")

    @property
    def command(self) -> Command:
        """What the participant is told; a contraction begins with START as a press does."""
        measuring = self.state.measuring
        contracting = measuring is not None and measuring.step == "contraction" and self.now_s < measuring.until_s
        return "start" if contracting else self.cycle.command

    def now(self) -> Now:
        """The state, and what no line of the journal says."""
        own, record = (self.emg, self.force), self.record
        return Now(
            self.state, self.now_s, self.bar.force_n, self.recent.steady, self.cycle.rest_until_s,
            any(stream.lost_why for stream in own), bool(self._unsafe),
            (own[0].view(self.now_s), own[1].view(self.now_s)),
            saved(record.folder, record.lines, record.trouble, record.is_safe),
        )  # fmt: skip

    # a press

    def press_begun(self, attempt: Attempt) -> None:
        """START was given, or the participant did not wait for it."""
        press = self.state.wanted
        assert press is not None
        if press == self.state.suggested:
            why = self.state.fits[press.specimen].suggestion
            self.write(journal.PressAdded(press.number, press.phase, press.specimen, press.repetition, press.stay, why))
        self.write(self.state.presses.begin(press), attempt.start_s)
        self._lost_at_start = (self.emg.lost_samples, self.force.lost_samples)
        self.screens.begin()

    def over(self, attempt: Attempt) -> None:
        """An attempt has ended: a complete one is judged once the rest after it has come."""
        if (running := self.state.running) is None:
            return
        assert attempt.end_s is not None
        begun_s = attempt.start_s if attempt.begun_s is None else attempt.begun_s
        complete = attempt.ending in ("lifted", "released")
        self.write(
            journal.PressEnded(
                *running.key, begun_s, attempt.end_s, "complete" if complete else "aborted", round(attempt.peak_n, 4),
                None, attempt.zero_n, self._lost_share(attempt.end_s - attempt.start_s), self.screens.age_ms,
                self.screens.hidden, self.emg.clock.uneven or self.force.clock.uneven,
            )
        )  # fmt: skip
        if complete:
            self.judge.ended(self.now_s)
        elif (ended := self.state.presses.find(*running.key)) is not None:
            self._tell_verdict(ended, attempt, StayJudged())

    def _lost_share(self, lasted_s: float) -> float:
        """Share of lost samples of the worse stream since START."""
        streams = (self.emg, self.force)
        lost = (own.lost_samples - then for own, then in zip(streams, self._lost_at_start, strict=True))
        own_s = max(lasted_s, TURN_S)
        return max(0.0, *(n / (own_s * own.info.fs_hz) for n, own in zip(lost, streams, strict=True)))

    def _work(self, now_s: float) -> None:
        """What waits for a time, or for the judge."""
        self.judge.turn(now_s, self.state)
        if (answered := self.judge.answer()) is not None:
            asked, answer, tried = answered
            if not isinstance(answer, StayJudged):
                self._take_signals(asked, answer)
            elif asked == "stay":
                self._take_verdicts(tried, answer)
            else:
                self._say(answer.failed, again=True)
        self._show_written()
        if now_s >= self._next_clock_s:
            self._next_clock_s = now_s + CLOCK_TOLD_S
            if now_s > 0:
                self._tell_clocks()
        if self.cycle.command == "start" and self.bar.force_n <= -self.settings.force_n[0]:
            self._say(WRONG_SIGN)
        overdue = self.cycle.overdue_s(now_s) > 0
        if overdue and not self._overdue:
            self._say(OVERDUE)
        self._overdue = overdue

    def _tell_clocks(self) -> None:
        self.emg.tell_clock()
        self.force.tell_clock()

    def _take_verdicts(self, of: list[Tried], judged: StayJudged) -> None:
        """Take the verdicts on the press that has ended. A verdict stays: a later fault in a stay is no fault of an
        earlier press.
        """
        for tried in of:
            self._tell_verdict(tried, tried.as_pressed(), judged, self.judge.samples)
        for said, do in judged.remarks:
            self._say(f"{said} -> {do}" if do else said)

    def _tell_verdict(
        self, tried: Tried, attempt: Attempt, stay: StayJudged, samples: dict[str, tuple[int, int]] | None = None
    ) -> None:
        """Write a verdict; it is in the state, and the pages show it, once it is on the disk itself."""
        window = how_judged(self.study, self.state.rules.participant, tried.press.specimen).window
        assert tried.ended is not None
        event = judge_attempt(tried.ended, attempt, stay, self.settings, window, samples or {})
        self.record.append(event, self.now_s)

    def _show_written(self) -> None:
        """Take the verdicts that are on the disk itself into the state; those of practice, while the disk refuses."""
        while self._unsafe and (
            self._unsafe[0].number <= self.record.safe_lines or (self.record.trouble and self._practising)
        ):
            line, before = self._unsafe.popleft(), self.state
            self.state = state.after(before, line)
            self._plug(line)
            assert isinstance(line.event, journal.Judged)
            tried = self.state.presses.find(line.event.press, line.event.attempt)
            if tried is not None and tried.ended is not None:
                self.verdict_delays_s.append(self.now_s - tried.ended.stop_s)
            self.changes += 1
            self.tell_suggestion(before)

    def tell_suggestion(self, before: state.SessionState) -> None:
        """Tell what a new fit suggests, where it suggests a further press; ``before`` it was another."""
        if (press := self.state.suggested) is not None:
            fit = self.state.fits[press.specimen]
            if before.fits.get(press.specimen) != fit:
                self.write(journal.Told(f"{press.specimen}: {fit.suggestion}"))

    # before the first press

    def measure(self, step: str) -> None:
        self.judge.measure(step, self.state)
        self.write(journal.Measuring("rest" if step == "rest" else "contraction"))

    def _take_signals(self, step: str, signals: tuple[SignalView, ...]) -> None:
        levels = {view.muscle: view.rest_v if step == "rest" else view.contraction_v for view in signals}
        known = {muscle: level for muscle, level in levels.items() if level is not None}
        problems = tuple(problem for view in signals for problem in view.problems)
        self.write(journal.QualityMeasured("rest" if step == "rest" else "contraction", known, problems))

    # specimens

    def place(self) -> None:
        press = self.state.wanted
        assert press is not None
        self.bar.zero_n = self.recent.mean_n
        self.write(journal.Checked(journal.PLACED, press.specimen))
        self._at_table = True
        self.judge.begin(self.state)

    def _leave(self) -> None:
        """The presses of this stay are done: the next specimen, after a break, with a new checklist."""
        if self._at_table and not self.state.placed:
            self._at_table = False
            self._tell_clocks()
            if self.state.wanted is not None:
                self.write(journal.Paused(journal.BETWEEN))

    # the end

    def end(self, how: str = "ended", why: str = "") -> None:
        """End the session now; a press under way is interrupted."""
        with self.lock:
            if self.state.ended is not None:
                return
            self._interrupt(self.now_s, why or "the session was ended")
            written = self.state
            for line in self._unsafe:
                written = state.after(written, line)
            if how == "ended" and written.wanted is None and written.presses.undecided is None:
                how = "completed"
            self.cycle.close("done")
            for stream in (self.emg, self.force):
                stream.close()
            self._say(self.screens.commands)
            self.write(journal.Ended(how, why))  # type: ignore[arg-type]
            self.record.wait(0.0 if self.record.trouble else LAST_LINES_S)
            self._show_written()
            self._show(self.now_s)
            self.judge.close()

    # what the participant's page says

    def screen(self, report: ScreenReport) -> None:
        """What the participant's page says of itself: kept with the press, and in the journal when it is news."""
        with self.lock:
            if self.state.ended is not None:
                return
            hidden, told = self.screens.take(report, self.now_s)
            if hidden:
                self._say(HIDDEN)
            if told is not None:
                self.write(told)

    # what is told

    def write(self, event: journal.Event, time_s: float | None = None) -> None:
        """A line of the journal, from which the state goes on."""
        self.record.append(event, self.now_s if time_s is None else time_s)
        self.changes += 1

    def _say(self, text: str, again: bool = False) -> None:
        """again : written each time, though it is shown already."""
        if text and (again or text not in self.state.warnings):
            self.write(journal.Told(text))

    def _show(self, now_s: float) -> None:
        self._leave()
        if self.closing and self.state.ended is None:
            self.end()
            return
        if self.command != self.state.command:
            about = self.state.running.key if self.state.running else (0, 0)
            self.write(journal.Commanded(self.command, *about))
        force_n = self.bar.force_n
        speed = self.cycle.speed(now_s, force_n)
        self.force_message = ForceMessage(
            self.force_message.sequence + 1, self._newest_force_s, round(force_n, 4), self.bar.direction, speed,
            self.command,
            self.force_message.command_s if self.command == self.force_message.command else now_s,
        )  # fmt: skip
        self.traces.turn(now_s, force_n)


def check_muscles(study: Study, channels: tuple[str, ...]) -> None:
    """SettingError where the source of the EMG has no channel for a muscle of the study."""
    missing = [muscle for muscle in study.recordings[0].channels.emg if muscle not in channels]
    if missing:
        raise SettingError(
            f"{study.path}, session.emg.channels", wanted=f"a channel for {', '.join(missing)}",
            found=f"channels {', '.join(channels)}", do="Name the source's channel of every muscle in [channels.emg].",
        )  # fmt: skip
