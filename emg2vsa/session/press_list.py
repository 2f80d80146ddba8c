"""The presses of a session as the operator sees them: planned, tried, judged, decided. It grows with the journal."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from emg2vsa.session import journal
from emg2vsa.session.live_press import Circumstances, FoundPress, Judged, Problem
from emg2vsa.session.plan import PlannedPress
from emg2vsa.session.press_cycle import Attempt
from emg2vsa.session.record import Progress
from emg2vsa.session.views import PressView


@dataclass
class Tried:
    """One attempt. times, found : of this sitting only."""

    press: PlannedPress
    attempt: int
    verdict: str = ""
    decision: str = ""
    problems: tuple[Problem, ...] = ()
    values: dict[str, float | None] = field(default_factory=dict)
    note: str = ""
    over: bool = False
    "It ended, and need not have been complete."
    complete: bool = False
    times: Attempt | None = None
    found: FoundPress | None = None
    around: Circumstances = field(default_factory=Circumstances)
    epochs: tuple[int, int] = (0, 0)
    "Of the streams that saw it."

    @property
    def undecided(self) -> bool:
        """Rejected, and the operator has not said what is to become of it."""
        return self.complete and self.verdict == "rejected" and not self.decision

    @property
    def counts(self) -> bool:
        """It stands for its press, as far as its execution goes."""
        if not self.complete or self.decision:
            return self.complete and self.decision == "accept"
        return self.verdict in ("ok", "warned")

    @property
    def usable(self) -> FoundPress | None:
        """What its fit knows of it, where it counts: of this sitting, or as the journal has it."""
        if not self.counts or self.found is not None:
            return self.found if self.counts else None
        a_v, b_v = self.values.get("a_v"), self.values.get("b_v")
        if a_v is None or b_v is None:
            return None
        return FoundPress(0.0, 0.0, self.verdict, "", 0.0, a_v, b_v, True)

    def view(self) -> PressView:
        """As the operator's page shows it."""
        own = self.press
        return PressView(
            own.number, own.specimen, own.phase, own.repetition, self.attempt, self.verdict, self.decision,
            self.problems, self.values.get("peak_n"), self.values.get("load_s"), self.note,
        )  # fmt: skip


class PressList:
    """What `Progress` counts, with what the pages show of it."""

    def __init__(self, progress: Progress) -> None:
        self._progress = progress
        self.tried: list[Tried] = []

    def take(self, event: journal.Event) -> None:
        """An event of the journal, of this sitting or of an earlier one; `Progress` has taken it already."""
        if isinstance(event, journal.PressBegun):
            press = next(press for press in self._progress.presses if press.number == event.press)
            self.tried.append(Tried(press, event.attempt))
            return
        if not isinstance(
            event, (journal.PressEnded, journal.Judged, journal.Decided, journal.Interrupted, journal.Noted)
        ):
            return
        own = self.find(event.press, event.attempt)
        if own is None:
            return
        if isinstance(event, journal.PressEnded):
            own.over, own.complete = True, event.how == "complete"
            own.values["peak_n"] = event.peak_n
        elif isinstance(event, journal.Interrupted):
            own.over, own.verdict = True, "rejected"
            own.problems = (("interrupted: the session ended within this press", "it is repeated"),)
        elif isinstance(event, journal.Judged):
            own.verdict, own.problems = event.verdict, event.problems
            own.values |= event.values
        elif isinstance(event, journal.Decided):
            own.decision = event.decision
        else:
            own.note = f"{own.note}; {event.text}" if own.note else event.text

    def find(self, press: int, attempt: int | None = None) -> Tried | None:
        """An attempt of a press, the last one where none is named."""
        own = [tried for tried in self.tried if tried.press.number == press]
        return next((tried for tried in reversed(own) if attempt in (None, tried.attempt)), None)

    @property
    def presses(self) -> tuple[PlannedPress, ...]:
        """All, in the order of pressing: those that were added belong to their stay."""
        return tuple(sorted(self._progress.presses, key=lambda press: (press.stay, press.number)))

    @property
    def next(self) -> PlannedPress | None:
        """The first one that is not done."""
        return self._progress.next

    @property
    def undecided(self) -> Tried | None:
        """The first rejected press that waits for the operator."""
        last = (self.find(press.number) for press in self.presses)
        return next((tried for tried in last if tried is not None and tried.undecided), None)

    def of_stay(self, stay: int) -> Iterator[Tried]:
        """Attempts at the presses of a stay."""
        return (tried for tried in self.tried if tried.press.stay == stay)

    def done(self, specimen: str) -> bool:
        """Whether every press of the main part on a specimen is done."""
        own = [press for press in self._progress.presses if (press.phase, press.specimen) == ("main", specimen)]
        return all(self._progress.is_done(press.number) for press in own)

    def repeats(self, press: PlannedPress) -> int:
        """Presses of its phase on its specimen that were decided to be done again."""
        return sum(
            tried.decision == "repeat"
            for tried in self.tried
            if (tried.press.phase, tried.press.specimen) == (press.phase, press.specimen)
        )

    def attempts(self, press: PlannedPress) -> int:
        """How often it has been begun."""
        return sum(tried.press.number == press.number for tried in self.tried)

    def place(self, press: PlannedPress) -> tuple[int, int]:
        """Which of how many presses of its phase it is, from 1."""
        own = [each.number for each in self.presses if each.phase == press.phase]
        return own.index(press.number) + 1, len(own)

    def views(self) -> tuple[PressView, ...]:
        """Every attempt, and every press that has none yet or is to be done again, in the order of pressing."""
        shown: list[PressView] = []
        for press in self.presses:
            own = [tried for tried in self.tried if tried.press.number == press.number]
            shown += [tried.view() for tried in own]
            if not own or (own[-1].verdict and not self._progress.is_done(press.number) and not own[-1].undecided):
                shown.append(Tried(press, len(own) + 1).view())
        return tuple(shown)


def judged_event(tried: Tried, judged: Judged) -> journal.Judged:
    """The line of the journal for a verdict."""
    found = judged.found
    values: dict[str, float | None] = {"peak_n": _rounded(judged.peak_n), "load_s": _rounded(judged.load_s)}
    if found is not None and found.fitted:
        values |= {"a_v": found.a_v, "b_v": found.b_v}
    verdict: journal.Verdict = (
        "ok" if judged.verdict == "ok" else "warned" if judged.verdict == "warned" else "rejected"
    )
    return journal.Judged(tried.press.number, tried.attempt, verdict, judged.problems, values)


def _rounded(value: float | None) -> float | None:
    return None if value is None else round(value, 4)
