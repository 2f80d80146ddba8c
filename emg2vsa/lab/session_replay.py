"""A session rebuilt from its folder: what its pages showed, and every verdict judged again from the samples on disk."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from emg2vsa.errors import DataError, SettingError
from emg2vsa.session import journal
from emg2vsa.session.bar_force import ZERO_S, BarForce, RecentForce
from emg2vsa.session.journal import JOURNAL_FILE, Judged, Line, gaps, read_journal
from emg2vsa.session.judge_feed import JUDGED_VALUES, SETTLE_S, how_judged, judged_from_s
from emg2vsa.session.legal import Now, operator_state, participant_state
from emg2vsa.session.live_press import StayJudged, judge_attempt
from emg2vsa.session.liveness import WINDOW_S, Liveness
from emg2vsa.session.open_session import kept_settings, settings_of
from emg2vsa.session.plan import PLAN_FILE, Plan, PlannedPress, changes, read_plan
from emg2vsa.session.presses import Presses, Tried, planned_of
from emg2vsa.session.raw_files import SampleFile
from emg2vsa.session.record import saved
from emg2vsa.session.recorded_stream import device_view
from emg2vsa.session.session import TURN_S, check_muscles
from emg2vsa.session.state import Rules, after, begun
from emg2vsa.session.stay_judge import Begin, JudgeAtOnce, JudgeStay, Samples
from emg2vsa.session.stays import StoredStream
from emg2vsa.session.views import DeviceView, OperatorState, ParticipantState
from emg2vsa.study import Study

_DIGIT_S = 1e-6
"""Last digit of a time in the journal."""
_OLDER = (
    "The journal is of an earlier version, which did not write the force before START, the lost samples and the page "
    "of each press. A verdict that rests on them cannot be made again."
)


@dataclass(frozen=True)
class ReplayedPress:
    """A complete press. before : its verdict in the journal. again : the one that its samples give now."""

    specimen: str
    before: Judged
    again: Judged

    @property
    def differences(self) -> tuple[str, ...]:
        """What is not the same, in words; verdict, problems and values to the last bit."""
        old, new = self.before, self.again
        told = {name: "; ".join(found for found, _ in each.problems) for name, each in (("was", old), ("is", new))}
        found = [f"verdict: was {old.verdict}, is {new.verdict}"] if old.verdict != new.verdict else []
        if old.problems != new.problems:
            found.append(f"problems: was {told['was'] or 'none'}, is {told['is'] or 'none'}")
        keys = [key for key in {**old.values, **new.values} if old.values.get(key) != new.values.get(key)]
        return (*found, *(f"{key}: was {old.values.get(key)}, is {new.values.get(key)}" for key in keys))


@dataclass(frozen=True)
class ReplayedSession:
    """A session as its folder has it.

    line : number of the last line that was replayed. operator, participant : what the two pages showed after it.
    presses : judged until then. notes : what is to be known of the replay, in sentences. whole : no line is missing.
    """

    folder: Path
    line: int
    operator: OperatorState
    participant: ParticipantState
    presses: tuple[ReplayedPress, ...]
    notes: tuple[str, ...]
    whole: bool = True

    @property
    def same(self) -> bool:
        """The journal lacks no line, and every verdict is the one that it has."""
        return self.whole and not any(press.differences for press in self.presses)


def replay(study: Study, folder: Path, *, line: int | None = None) -> ReplayedSession:
    """Rebuild what the pages of a session showed, and judge its complete presses again. Nothing is written.

    It may be done while the session runs.

    Parameters
    ----------
    study : the study of the session, by whose settings it is judged.
    folder : of the session: sourcedata/sub-P03/<task> below the root of the recordings.
    line : number of the line of the journal after which the pages are shown; None: the last one.

    Raises
    ------
    SettingError : the study has no [session] or not the session's participant; there is no such line.
    DataError : there is no session; it is of another study; its plan, journal or samples are damaged or missing, or do
        not fit each other.

    Examples
    --------
    >>> from emg2vsa import session
    >>> session.replay(study, study.data / "sourcedata" / "sub-P03" / "press").same  # doctest: +SKIP
    True
    """
    plan = read_plan(folder / PLAN_FILE)
    if plan.study != study.name:
        raise DataError(
            folder, wanted=f"a session of the study {study.name}", found=f"one of {plan.study}",
            do="Name the study file with which the session was run.",
        )  # fmt: skip
    settings_of(study := study.at_visit(plan.visit or None), plan.participant)
    lines, whole = read_journal(folder / JOURNAL_FILE)
    shown = lines if line is None else [each for each in lines if each.number <= line]
    if not lines:
        raise DataError(
            folder / JOURNAL_FILE, wanted="the journal of a session", found="no whole line",
            do="Put the file back from a copy.",
        )  # fmt: skip
    if line is not None and line not in {each.number for each in lines}:
        wanted = f"a line of {folder / JOURNAL_FILE}, 1 to {lines[-1].number}"
        raise SettingError("--line", wanted=wanted, found=str(line), do="Choose one of them.")
    _check_plan(folder, plan, lines)
    table = _Replay(study, folder, Presses(plan.presses), plan.participant)
    presses = tuple(press for each in shown for press in table.take(each))
    torn = (folder / JOURNAL_FILE).stat().st_size - whole
    missing = gaps(shown)
    notes = [
        *missing,
        *(f"The study file has changed since: {change}." for change in changes(plan.settings, kept_settings(study))),
    ]
    if torn > 0 and line is None:
        notes.append(f"The last {torn} bytes of the journal are no whole line; they are passed over.")
    if table.older:
        notes.append(_OLDER)
    now = table.now(shown[-1])
    number = shown[-1].number
    pages = operator_state(now), participant_state(now)
    return ReplayedSession(folder, number, *pages, presses, tuple(notes), not missing)


def _check_plan(folder: Path, plan: Plan, lines: Sequence[Line]) -> None:
    """DataError where the journal was not written with this plan."""

    def check(wanted: str, where: str, found: str) -> None:
        if wanted != found:
            raise DataError(
                folder / PLAN_FILE, wanted=f"{wanted}, as {where}", found=found,
                do=f"Put it and {JOURNAL_FILE} back from a copy; neither is ever changed.",
            )  # fmt: skip

    for place, press in enumerate(plan.presses, 1):
        check(f"press {place} at place {place}", "every plan has it", f"press {press.number} at place {place}")
    presses = {press.number: press for press in plan.presses}
    for line in lines:
        where = f"line {line.number} of {JOURNAL_FILE} says"
        match line.event:
            case journal.Begun(participant=participant, study=study):
                check(f"participant {participant}", where, f"participant {plan.participant}")
                check(f"study {study}", where, f"study {plan.study}")
            case journal.PressAdded(number=number) as added:
                check(f"{number - 1} presses until then", where, f"{len(presses)} presses until then")
                presses[number] = planned_of(added, number)
            case journal.PressBegun(press=number) as begins:
                check(_in_words(planned_of(begins, number)), where, _in_words(presses.get(number)))


def _in_words(press: PlannedPress | None) -> str:
    if press is None:
        return "no such press"
    return f"press {press.number} ({press.phase}, {press.specimen}, repetition {press.repetition}, stay {press.stay})"


class _Replay:
    """The state of a session, its streams and its judge, a line after another."""

    def __init__(self, study: Study, folder: Path, presses: Presses, participant: str) -> None:
        self.state = begun(Rules.of(study, participant), presses)
        self.older = False
        self._study, self._folder = study, folder
        self._judge = JudgeAtOnce()
        self._streams: dict[str, StoredStream] = {}
        self._first: dict[str, int] = {}
        "First sample of the stay, by stream."
        self._lost: dict[str, int] = {}
        self._ended_s = self._zero_n = 0.0

    def take(self, line: Line) -> Iterator[ReplayedPress]:
        """One more line; the press whose verdict it is, if it is one."""
        match line.event:
            case journal.Begun():
                self._lost = {}
            case journal.StreamOpened() as opened:
                if (earlier := self._streams.get(opened.name)) is not None:
                    self._count_lost(opened.name, earlier.clock.report().missing)
                self._streams[opened.name] = StoredStream(opened, self._file(opened))
                self._begin_stay(line.time_s)
            case journal.SamplesLost(stream=name, count=count):
                self._count_lost(name, count)
            case journal.Checked(item=journal.PLACED):
                self._zero_n = self._recent(line.time_s).mean_n
                self._begin_stay(line.time_s)
            case journal.PressEnded() as ended:
                self._ended_s = line.time_s
                self.older |= ended.peak_n is not None and ended.zero_n is None
            case Judged() as judged if (own := self.state.presses.find(judged.press, judged.attempt)) and own.complete:
                yield ReplayedPress(own.press.specimen, judged, self._again(own, judged, line.time_s))
        self.state = after(self.state, line)

    def _file(self, opened: journal.StreamOpened) -> SampleFile:
        """The samples of a stream, which are those that the journal tells of."""
        file = SampleFile(self._folder / opened.file)
        wanted, found = (
            f"{own.kind} of {', '.join(own.channels)} in {own.unit} at {own.fs_hz:g} Hz" for own in (opened, file.info)
        )
        if wanted != found:
            raise DataError(
                file.path, wanted=f"{wanted}, as {JOURNAL_FILE} says", found=found, do="Put the file back from a copy."
            )
        if opened.name == "emg":
            check_muscles(self._study, opened.channels)
        return file

    def _count_lost(self, name: str, count: int) -> None:
        self._lost[name] = self._lost.get(name, 0) + count

    def _begin_stay(self, now_s: float) -> None:
        self._first = {name: _stop(own, now_s) for name, own in self._streams.items()}

    def _again(self, tried: Tried, event: Judged, now_s: float) -> Judged:
        specimen, rules = tried.press.specimen, self.state.rules
        for name in ("emg", "force"):
            if name not in self._streams:
                raise DataError(
                    self._folder / JOURNAL_FILE, wanted=f"a line that opens {name} before press {event.press}",
                    found="none", do="Put the file back from a copy; lines are never removed.",
                )  # fmt: skip
        samples = event.samples or self._samples(tried, now_s)
        how = how_judged(self._study, rules.participant, specimen)
        self._judge.tell(Begin(rules.participant, specimen, how, {name: at for at, name in enumerate(rules.muscles)}))
        for name, (first, stop) in samples.items():
            stream = self._streams[name]
            if stop > stream.file.stop:
                raise DataError(
                    stream.file.path, wanted=f"the samples {first} to {stop} of press {event.press}",
                    found=f"samples to {stream.file.stop}", do="Put the file back from a copy.",
                )  # fmt: skip
            stream.hear(stop)
            columns = [stream.opened.channels.index(m) for m in rules.muscles] if name == "emg" else [0]
            self._judge.tell(Samples(name, first, stream.file.read(first, stop)[:, columns].astype(np.float32)))
        self._judge.tell(JudgeStay({name: self._streams[name].clock.timing(*own) for name, own in samples.items()}))
        judged = self._judge.answer()
        assert isinstance(judged, StayJudged)
        assert tried.ended is not None
        return judge_attempt(tried.ended, tried.as_pressed(), judged, rules.settings, how.window, samples)

    def _samples(self, tried: Tried, now_s: float) -> dict[str, tuple[int, int]]:
        """What the judge was given, where the journal does not say it: by the times at which samples came."""
        asked_s = min(now_s, self._ended_s + SETTLE_S + TURN_S)
        stops = {name: _stop(own, asked_s) for name, own in self._streams.items()}
        clocks = {name: own.hear(stops[name]).clock for name, own in self._streams.items()}
        longest_s = JUDGED_VALUES / (len(self.state.rules.muscles) * self._streams["emg"].opened.fs_hz)
        presses = self.state.presses
        from_s = judged_from_s(presses, tried.press.stay, clocks["emg"].time_s(self._first["emg"]), asked_s, longest_s)
        firsts = {name: max(self._first[name], clocks[name].first_after(from_s, stop)) for name, stop in stops.items()}
        return {name: (firsts[name], stop) for name, stop in stops.items()}

    def now(self, line: Line) -> Now:
        """The state at the time of a line, with what the samples say that had come by then."""
        state, now_s = self.state, round(line.time_s, journal.TIME_DIGITS)
        bar = BarForce(state.rules.settings.bar_filter_hz)
        bar.zero_n = self._zero_n
        if (force := self._streams.get("force")) is not None:
            stop = _stop(force, now_s)
            bar.take(force.file.read(max(0, stop - round(force.opened.fs_hz)), stop)[:, 0], force.opened.fs_hz, now_s)
        devices = tuple(self._device(name, own, now_s) for name, own in sorted(self._streams.items()))
        resting_s = math.inf if state.command == "rest" else 0.0
        return Now(
            state, now_s, bar.force_n, self._recent(now_s).steady, resting_s,
            any(own.state == "lost" for own in devices), False, devices, saved(self._folder, line.number, "", True),
        )  # fmt: skip

    def _device(self, name: str, stream: StoredStream, now_s: float) -> DeviceView:
        heard = stream.hear(_stop(stream, now_s)).heard
        blocks = stream.file.blocks
        shown = {"emg": "EMG", "force": "Force"}
        told = [each for each in self.state.warnings if each.startswith(tuple(f"{own}: " for own in shown.values()))]
        is_lost = self.state.paused == "device" and told and told[-1].startswith(f"{shown[name]}: ")
        why = told[-1].partition(": ")[2] if is_lost else ""
        lost = self._lost.get(name, 0) + stream.clock.report().missing
        samples = 0 if self.state.ended is not None or why else int(blocks.count[:heard].sum())
        silent_s = now_s - (float(blocks.arrived_s[heard - 1]) if heard else now_s)
        signs = [] if self.state.ended is not None else self._signs(stream, now_s)
        return device_view(name, stream.clock, signs, samples, lost, silent_s, why)

    @staticmethod
    def _signs(stream: StoredStream, now_s: float) -> list[str]:
        """What the liveness of a stream told at a time."""
        blocks = stream.file.blocks
        near = (blocks.arrived_s <= now_s + _DIGIT_S) & (blocks.arrived_s >= now_s - WINDOW_S - _DIGIT_S)
        liveness = Liveness(stream.file.info, float(blocks.arrived_s.min(initial=now_s)))
        for i in np.flatnonzero(near).tolist():
            first = int(blocks.first[i])
            samples = stream.file.read(first, first + int(blocks.count[i]))
            liveness.take(samples, float(blocks.arrived_s[i]))
        return list(liveness.problems(now_s))

    def _recent(self, now_s: float) -> RecentForce:
        """The force of the half second before a time."""
        recent = RecentForce()
        if (force := self._streams.get("force")) is not None:
            first, stop = _stop(force, now_s - ZERO_S - _DIGIT_S), _stop(force, now_s)
            if stop > first:
                recent.take(force.file.read(first, stop)[:, 0], now_s)
        return recent


def _stop(stream: StoredStream, now_s: float) -> int:
    """One past the last sample that had come by a time."""
    blocks = stream.file.blocks
    came = blocks.arrived_s <= now_s + _DIGIT_S
    return int((blocks.first + blocks.count)[came].max(initial=0))
