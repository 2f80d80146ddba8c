"""What a session is at a moment: a fold over its journal. A line is the only thing that changes it.

``after(state, line)`` is the state after one more line. A session that runs, one that is resumed and one that is
replayed from its folder fold the same lines, so each of them knows the same.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from scipy import special

from emg2vsa.durable.writer import DISK_TROUBLE
from emg2vsa.session import journal, quality
from emg2vsa.session.journal import Line
from emg2vsa.session.plan import PlannedPress
from emg2vsa.session.presses import Presses, Tried
from emg2vsa.session.screens import HIDDEN
from emg2vsa.session.stay_judge import JUDGE_ENDED
from emg2vsa.session.views import DEVICE_NAMES, Command, ScreenReport, SignalView, SpecimenFit
from emg2vsa.session_settings import SessionSettings
from emg2vsa.study import Study

MOST_WARNINGS = 8
DISK_BACK = "The disk takes the recording again."
NO_QUALITY = "The session begins without a measurement of the signal quality."


def goes_on(specimen: str) -> str:
    """Told when a further press that was suggested is left out."""
    return f"{specimen}: the operator goes on without a further press."


@dataclass(frozen=True)
class Rules:
    """What a state follows beside its journal: the study file. title : with the visit, where there are several.
    muscles : in the order of their columns.
    """

    title: str
    participant: str
    settings: SessionSettings
    muscles: tuple[str, ...]
    confidence: float

    @classmethod
    def of(cls, study: Study, participant: str) -> Rules:
        """State at the beginning of a study with a table [session]."""
        muscles = tuple(study.recordings[0].channels.emg)
        assert study.session is not None
        title = f"{study.title or study.name}{study.visit and f', visit {study.visit}'}"
        return cls(title, participant, study.session, muscles, study.fit.confidence)


@dataclass(frozen=True)
class Measurement:
    """Measurement of the signal quality. step : "rest" or "contraction". It waits for its judge from ``until_s`` on."""

    step: str
    until_s: float


@dataclass(frozen=True)
class SessionState:
    """State of the sitting that goes on, but for ``presses``, which are those of all sittings.

    command : what the participant is told. stay : the press for which the specimen on the table was placed.
    break_until_s : end of the break between two specimens. declined : specimens on which no further press is wanted.
    """

    rules: Rules
    presses: Presses
    sitting: int = 1
    command: Command = "wait"
    measuring: Measurement | None = None
    rest_measured: bool = False
    signals: tuple[SignalView, ...] = ()
    quality_done: bool = False
    stay: PlannedPress | None = None
    placed: bool = False
    checklist: Mapping[str, bool] = field(default_factory=dict)
    paused: str = ""
    break_until_s: float = 0.0
    fits: Mapping[str, SpecimenFit] = field(default_factory=dict)
    suggested: PlannedPress | None = None
    declined: frozenset[str] = frozenset()
    warnings: tuple[str, ...] = ()
    ended: journal.Ended | None = None

    @property
    def running(self) -> Tried | None:
        """The press that is under way."""
        return self.presses.running

    @property
    def wanted(self) -> PlannedPress | None:
        """The press that comes next: of the plan, or one that is suggested on the specimen on the table."""
        return self.suggested or self.presses.next

    @property
    def here(self) -> bool:
        """Whether the specimen of the press that comes next is on the table."""
        return self.placed and self.wanted is not None and self.stay is not None and self.wanted.stay == self.stay.stay

    @property
    def judging(self) -> bool:
        """Whether a press that has ended waits for its verdict."""
        return self.sitting in self.presses.judging

    @property
    def unchecked(self) -> list[str]:
        """Items of the checklist that are to be confirmed."""
        return [item for item, done in self.checklist.items() if not done]


def begun(rules: Rules, presses: Presses, sitting: int = 1) -> SessionState:
    """State of a sitting that begins."""
    return SessionState(rules, presses, sitting, checklist=dict.fromkeys(rules.settings.checklist, False))


def after(state: SessionState, line: Line) -> SessionState:
    """The state after one more line of the journal."""
    presses = state.presses.after(line)
    if isinstance(line.event, journal.Begun):
        return begun(state.rules, presses, line.sitting)
    state = replace(state, presses=presses)
    state = replace(state, **_changed(state, line))
    if isinstance(line.event, (journal.Judged, journal.Decided)) and state.stay is not None:
        state = replace(state, **_fitted(state, state.stay))
    left = state.placed and not (state.here or state.running or state.judging or presses.undecided)
    return replace(state, placed=False, checklist=_none_checked(state)) if left else state


def _changed(state: SessionState, line: Line) -> dict[str, Any]:
    match line.event:
        case journal.Commanded(command=command, press=press):
            # a journal of before there was `Measuring` tells the contraction by its command alone
            old = command == "start" and not press and state.measuring is None
            return {"command": command} | ({"measuring": _measurement("contraction", line)} if old else {})
        case journal.Measuring(step=step):
            return {"measuring": _measurement(step, line)} | ({"rest_measured": False} if step == "rest" else {})
        case journal.QualityMeasured() as event:
            return {
                "measuring": None, "signals": _signals(state, event),
                "rest_measured": state.rest_measured or event.step == "rest",
                "quality_done": state.quality_done or event.step == "contraction",
            }  # fmt: skip
        case journal.Checked(item=journal.PLACED):
            return {"stay": state.wanted or state.stay, "placed": True}
        case journal.Checked(item=item) | journal.Unchecked(item=item) if item in state.checklist:
            return {"checklist": {**state.checklist, item: isinstance(line.event, journal.Checked)}}
        case journal.PressEnded(peak_n=peak_n) if state.rules.settings.check_each_press and peak_n is not None:
            return {"checklist": {**state.checklist, **dict.fromkeys(list(state.checklist)[:1], False)}}
        case journal.PressAdded():
            return {"suggested": None}
        case journal.Paused(why=journal.BETWEEN):
            at_s = round(line.time_s, journal.TIME_DIGITS)
            return {"break_until_s": at_s + state.rules.settings.pause_s}
        case journal.Paused(why=why):
            broken_off = state.measuring is not None and line.time_s < state.measuring.until_s and why != "operator"
            return {"paused": why} | ({"measuring": None} if broken_off else {})
        case journal.Continued():
            return {"paused": ""}
        case journal.StreamOpened(name=name):
            return _over(state, f"{DEVICE_NAMES[name]}: ")
        case ScreenReport(hidden=False):
            return _over(state, HIDDEN)
        case journal.Told(text=text):
            return _told(state, text)
        case journal.Ended() as event:
            return {"ended": event, "measuring": None}
    return {}


def _measurement(step: str, line: Line) -> Measurement:
    return Measurement(step, line.time_s + (quality.REST_S if step == "rest" else quality.CONTRACTION_S))


def _none_checked(state: SessionState) -> dict[str, bool]:
    return dict.fromkeys(state.rules.settings.checklist, False)


def _over(state: SessionState, begins: str) -> dict[str, Any]:
    """Warnings that begin so are over: a device is back, the page is shown, the disk has room."""
    return {"warnings": tuple(text for text in state.warnings if not text.startswith(begins))}


def _told(state: SessionState, text: str) -> dict[str, Any]:
    """Most of what is told is a warning; some sentences tell what the operator chose, or that a trouble is over."""
    if text == DISK_BACK:
        return _over(state, DISK_TROUBLE)
    if text == NO_QUALITY:
        return {"quality_done": True}
    if state.suggested is not None and text == goes_on(state.suggested.specimen):
        return {"declined": state.declined | {state.suggested.specimen}, "suggested": None}
    if text in (f"{specimen}: {fit.suggestion}" for specimen, fit in state.fits.items()):
        return {}
    changed: dict[str, Any] = {"measuring": None} if text == JUDGE_ENDED else {}
    return changed if text in state.warnings else changed | {"warnings": (*state.warnings, text)[-MOST_WARNINGS:]}


def _signals(state: SessionState, event: journal.QualityMeasured) -> tuple[SignalView, ...]:
    """Signals of every muscle. Each problem has the muscle's name at its beginning or at its end."""
    muscles = state.rules.muscles
    if not event.levels_v:  # what made it impossible is told of every muscle
        return tuple(SignalView(muscle, problems=event.problems[:1]) for muscle in muscles)
    rest_v = {view.muscle: view.rest_v for view in state.signals} if event.step == "contraction" else event.levels_v
    contraction_v = event.levels_v if event.step == "contraction" else {}
    return tuple(
        SignalView(
            muscle, rest_v.get(muscle), contraction_v.get(muscle),
            quality.snr_db_of(rest_v.get(muscle), contraction_v.get(muscle)),
            tuple(each for each in event.problems if quality.muscle_of(each[0], muscles) == muscle),
        )
        for muscle in muscles
    )  # fmt: skip


def _fitted(state: SessionState, stay: PlannedPress) -> dict[str, Any]:
    """The fit on the specimen on the table once its presses are done, and the further press that it suggests."""
    rules, presses = state.rules, state.presses
    own = presses.of_specimen(stay)
    if stay.phase != "main" or not {press.number for press in own} <= presses.done:
        return {"suggested": None}
    on_it = (tried for tried in presses.tried if tried.press.specimen == stay.specimen)
    slopes = [each.slope for each in on_it if presses.counting.get(each.press.number) == each.attempt and each.slope]
    fit = specimen_fit(stay.specimen, slopes, rules.confidence, rules.settings, len(own))
    if fit is None:
        return {"suggested": None}
    suggested = None
    if fit.suggestion and stay.specimen not in state.declined:
        number = max(press.number for press in presses.planned) + 1
        repetition = max(press.repetition for press in own) + 1
        suggested = PlannedPress(number, "main", stay.specimen, repetition, stay.stay)
    return {"fits": {**state.fits, stay.specimen: fit}, "suggested": suggested}


def specimen_fit(
    specimen: str, slopes: Sequence[tuple[float, float]], confidence: float, settings: SessionSettings, planned: int
) -> SpecimenFit | None:
    """Mean slope of the presses that count, with the Student interval over presses; None with fewer than two.

    slopes : a and b of their fits, V and V per ln N. planned : presses of the specimen that count or are still to be
    done. A suggestion is made only where the study set stop = "width" before the session, and depends on the interval's
    width beside the activity at 1 N, never on b.
    """
    if (n := len(slopes)) < 2:
        return None
    a_v, b_v = np.array(slopes).T.copy()
    half_v = float(special.stdtrit(n - 1, (1 + confidence) / 2) * b_v.std(ddof=1) / np.sqrt(n))
    mean_v = float(b_v.mean())
    said = _suggestion(half_v, float(a_v.mean()), planned, settings)
    return SpecimenFit(specimen, n, mean_v, mean_v - half_v, mean_v + half_v, said)


def _suggestion(half_v: float, level_v: float, planned: int, settings: SessionSettings) -> str:
    if settings.stop != "width" or planned >= settings.most_presses or level_v <= 0:
        return ""
    width = half_v / level_v
    if width <= settings.width:
        return ""
    wide, wanted = f"{100 * width:.0f} %", f"{100 * settings.width:.3g} %"
    return f"The interval of b is {wide} of the activity at 1 N; {wanted} is wanted. One more press is suggested."
