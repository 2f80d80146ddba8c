"""The presses of a session: planned, tried, judged, decided. They grow with the journal, a line at a time."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from itertools import groupby

from emg2vsa.session import journal
from emg2vsa.session.journal import Line
from emg2vsa.session.plan import PlannedPress
from emg2vsa.session.press_cycle import Attempt, Ending
from emg2vsa.session.views import PressView

_INTERRUPTED = (("interrupted: the session ended within this press", "it is repeated"),)
_EARLY_S = 1e-5
"""No press follows START so soon: it came first."""


@dataclass(frozen=True)
class Tried:
    """One attempt at a press. begun_s : START. stop_s : STOP, None where it was not told. files : of its samples, by
    stream. placed_s : the specimen was placed, None where the streams were opened later. interrupted : the sitting
    ended before its verdict.
    """

    press: PlannedPress
    attempt: int
    sitting: int = 0
    begun_s: float = 0.0
    stop_s: float | None = None
    ended: journal.PressEnded | None = None
    judged: journal.Judged | None = None
    decided: journal.Decided | None = None
    interrupted: bool = False
    notes: tuple[str, ...] = ()
    files: Mapping[str, str] = field(default_factory=dict)
    placed_s: float | None = None

    @property
    def key(self) -> tuple[int, int]:
        """Number of the press, and of the attempt."""
        return self.press.number, self.attempt

    @property
    def over(self) -> bool:
        """It ended, and need not have been complete."""
        return self.interrupted or self.ended is not None

    @property
    def complete(self) -> bool:
        return self.ended is not None and self.ended.how == "complete" and not self.interrupted

    @property
    def pressed(self) -> bool:
        """It was not left out before it began, and has ended."""
        return self.ended is not None and self.ended.peak_n is not None

    @property
    def awaits_verdict(self) -> bool:
        return self.over and not self.verdict and not self.decision

    @property
    def verdict(self) -> str:
        return "rejected" if self.interrupted else "" if self.judged is None else self.judged.verdict

    @property
    def decision(self) -> journal.Decision:
        return "" if self.decided is None else self.decided.decision

    @property
    def undecided(self) -> bool:
        """Rejected, and the operator has not said what is to become of it."""
        return self.complete and self.verdict == "rejected" and not self.decision

    @property
    def counts(self) -> bool:
        """It stands for its press: complete and well done, or accepted in spite of its faults."""
        if not self.complete or self.decision:
            return self.complete and self.decision == "accept"
        return self.verdict in ("ok", "warned")

    @property
    def values(self) -> Mapping[str, float | None]:
        """Measured of it: peak_n, load_s, and where it has a fit a_v and b_v."""
        peak_n = {} if self.ended is None else {"peak_n": self.ended.peak_n}
        return peak_n if self.judged is None else peak_n | self.judged.values

    @property
    def slope(self) -> tuple[float, float] | None:
        """a and b of its fit, V and V per ln N, where it counts and has one."""
        a_v, b_v = self.values.get("a_v"), self.values.get("b_v")
        return (a_v, b_v) if self.counts and a_v is not None and b_v is not None else None

    def as_pressed(self) -> Attempt:
        """What is known of the press of a complete attempt, as the journal has it."""
        assert self.ended is not None
        begun_s, peak_n = self.ended.start_s, self.ended.peak_n or 0.0
        early = begun_s - self.begun_s < _EARLY_S
        ending: Ending = "released" if self.stop_s is None else "lifted"
        return Attempt(
            self.begun_s, early, begun_s, self.stop_s, self.ended.stop_s, peak_n, self.ended.zero_n or 0.0, ending
        )  # fmt: skip

    def view(self) -> PressView:
        """As the operator's page shows it."""
        own = self.press
        problems = _INTERRUPTED if self.interrupted else () if self.judged is None else self.judged.problems
        return PressView(
            own.number, own.specimen, own.phase, own.repetition, self.attempt, self.verdict, self.decision,
            problems, self.values.get("peak_n"), self.values.get("load_s"), "; ".join(self.notes),
        )  # fmt: skip

    def after(self, line: Line) -> Tried:
        """As it is after a line about it."""
        match line.event:
            case journal.Commanded(command="stop") if not self.over:
                return replace(self, stop_s=_as_written(line))
            case journal.PressEnded() as ended:
                return replace(self, ended=ended)
            case journal.Interrupted():
                return replace(self, interrupted=True)
            case journal.Judged() as judged:
                return replace(self, judged=judged)
            case journal.Decided() as decided:
                return replace(self, decided=decided)
            case journal.Noted(text=text):
                return replace(self, notes=(*self.notes, text))
        return self


@dataclass(frozen=True)
class Presses:
    """planned : of the plan, and those added. tried : in their order. files : of the streams, newest, by name.

    placed_s : the specimen on the table was placed, since the streams are open.
    """

    planned: tuple[PlannedPress, ...]
    tried: tuple[Tried, ...] = ()
    files: Mapping[str, str] = field(default_factory=dict)
    placed_s: float | None = None

    def after(self, line: Line) -> Presses:
        """As they are after a line of the journal."""
        match line.event:
            case journal.StreamOpened(name=name, file=file):
                return replace(self, files={**self.files, name: file}, placed_s=None)
            case journal.Checked(item=journal.PLACED):
                return replace(self, placed_s=_as_written(line))
            case journal.PressAdded() as event:
                return replace(self, planned=(*self.planned, planned_of(event, event.number)))
            case journal.PressBegun() as event:
                begun = Tried(
                    planned_of(event, event.press), event.attempt, line.sitting, _as_written(line),
                    files=self.files, placed_s=self.placed_s,
                )  # fmt: skip
                return replace(self, tried=(*self.tried, begun))
            case (
                journal.Commanded(press=press, attempt=attempt)
                | journal.PressEnded(press=press, attempt=attempt)
                | journal.Judged(press=press, attempt=attempt)
                | journal.Decided(press=press, attempt=attempt)
                | journal.Interrupted(press=press, attempt=attempt)
                | journal.Noted(press=press, attempt=attempt)
            ) if self.find(press, attempt) is not None:
                tried = (own.after(line) if own.key == (press, attempt) else own for own in self.tried)
                return replace(self, tried=tuple(tried))
        return self

    def find(self, press: int, attempt: int | None = None) -> Tried | None:
        """An attempt of a press, the last one where none is named."""
        own = reversed(self._by_number.get(press, []))
        return next((tried for tried in own if attempt in (None, tried.attempt)), None)

    def begin(self, press: PlannedPress) -> journal.PressBegun:
        """The line that begins its next attempt."""
        number = len(self.of(press)) + 1
        return journal.PressBegun(press.number, number, press.specimen, press.phase, press.repetition, press.stay)

    def of(self, press: PlannedPress) -> list[Tried]:
        """Attempts at a press."""
        return self._by_number.get(press.number, [])

    @cached_property
    def _by_number(self) -> dict[int, list[Tried]]:
        """Attempts at each press that has one. A sitting of hours asks for them in every turn."""
        found: dict[int, list[Tried]] = {}
        for tried in self.tried:
            found.setdefault(tried.press.number, []).append(tried)
        return found

    def of_stay(self, stay: int) -> Iterator[Tried]:
        """Attempts at the presses of a stay that have ended, seen by the streams as they are now."""
        return (t for t in self.tried if t.press.stay == stay and t.pressed and t.files == self.files)

    def stays(self) -> Iterator[list[Tried]]:
        """Attempts at one stay, one after another, with the specimen placed once and the same streams."""
        for _, own in groupby(self.tried, lambda t: (t.sitting, t.press.phase, t.press.stay, t.placed_s, t.files)):
            yield list(own)

    @cached_property
    def in_order(self) -> tuple[PlannedPress, ...]:
        """All, in the order of pressing: those that were added belong to their stay."""
        return tuple(sorted(self.planned, key=lambda press: (press.stay, press.number)))

    @cached_property
    def running(self) -> Tried | None:
        """The attempt that is under way."""
        return self.tried[-1] if self.tried and not self.tried[-1].over else None

    @cached_property
    def counting(self) -> dict[int, int]:
        """By press the attempt that stands for it: the last one that counts."""
        return {tried.press.number: tried.attempt for tried in self.tried if tried.counts}

    @cached_property
    def done(self) -> frozenset[int]:
        """Presses that need no further attempt: one counts, or the last one is skipped.

        A rejected one needs the operator's decision first.
        """
        last = {tried.press.number: tried for tried in self.tried}
        return frozenset(self.counting) | {number for number, own in last.items() if own.decision == "skip"}

    @cached_property
    def next(self) -> PlannedPress | None:
        """The first one that is not done; None when all are."""
        return next((press for press in self.in_order if press.number not in self.done), None)

    @cached_property
    def undecided(self) -> Tried | None:
        """The first rejected press that waits for the operator."""
        last = (self.find(press.number) for press in self.in_order)
        return next((tried for tried in last if tried is not None and tried.undecided), None)

    @cached_property
    def judging(self) -> frozenset[int]:
        """Sittings in which a press that has ended waits for its verdict."""
        return frozenset(tried.sitting for tried in self.tried if tried.awaits_verdict)

    @cached_property
    def without_verdict(self) -> tuple[Tried, ...]:
        """Attempts that run, or ended complete and wait for their verdict; on resume those that were interrupted."""
        return tuple(own for own in self.tried if not own.verdict and (own.complete or not own.over))

    def of_specimen(self, press: PlannedPress) -> list[PlannedPress]:
        """Presses of its phase on its specimen."""
        return [own for own in self.in_order if (own.phase, own.specimen) == (press.phase, press.specimen)]

    def repeats(self, press: PlannedPress) -> int:
        """Attempts of its phase on its specimen that were decided to be done again."""
        own = {each.number for each in self.of_specimen(press)}
        return sum(tried.decision == "repeat" for tried in self.tried if tried.press.number in own)

    def place(self, press: PlannedPress) -> tuple[int, int]:
        """Number of the press, from 1, and count of the presses of its phase."""
        own = [each.number for each in self.in_order if each.phase == press.phase]
        return own.index(press.number) + 1, len(own)

    def views(self) -> tuple[PressView, ...]:
        """Every attempt, and every press that has none yet or is to be done again, in the order of pressing."""
        shown: list[PressView] = []
        for press in self.in_order:
            own = self.of(press)
            shown += [tried.view() for tried in own]
            if not own or (own[-1].verdict and press.number not in self.done and not own[-1].undecided):
                shown.append(Tried(press, len(own) + 1).view())
        return tuple(shown)


def folded(lines: Iterable[Line], planned: tuple[PlannedPress, ...]) -> Presses:
    """The presses after all these lines."""
    presses = Presses(planned)
    for line in lines:
        presses = presses.after(line)
    return presses


def planned_of(event: journal.PressBegun | journal.PressAdded, number: int) -> PlannedPress:
    rest = {each.name: getattr(event, each.name) for each in fields(PlannedPress) if each.name != "number"}
    return PlannedPress(number, **rest)


def _as_written(line: Line) -> float:
    """The time of a line as the journal has it, so that who reads it knows no less."""
    return round(line.time_s, journal.TIME_DIGITS)
