"""A session that plays by itself as soon as it is told to start: what the pages are tested with, without an engine."""

from __future__ import annotations

import math
import threading
from dataclasses import replace
from typing import ClassVar

import numpy as np

from emg2vsa.devices.clock import Clock
from emg2vsa.session.views import (
    DeviceView,
    Direction,
    ForceMessage,
    OperatorState,
    ParticipantState,
    PressView,
    Request,
    ScreenReport,
    SignalView,
    SpecimenFit,
    TraceMessage,
)
from emg2vsa.session_settings import SessionTexts

REACTION_S, LOAD_S, HELD_S, RELEASE_S, VERDICT_S = 0.4, 2.0, 0.3, 0.4, 0.5
PEAK_N, FORCE_N, BAR_N = 7.0, (0.5, 7.0), 7.0
A_V, B_V, REST_V = {"EDC": 30e-6, "FDS": 40e-6}, {"EDC": 22e-6, "FDS": 31e-6}, 3e-6
TOO_FAST = (("force goes from 0.5 to 7 N in 0.4 s; 1 to 5 s wanted", "ask for a slower press, and repeat it"),)
PLAN = (
    *(PressView(n, "soft practice", "training", n, 1) for n in (1, 2)),
    *(PressView(n, "S3", "main", n - 2, 1) for n in range(3, 6)),
    *(PressView(n, "S1", "main", n - 5, 1) for n in range(6, 9)),
)
TEXTS = SessionTexts()


class ScriptedDesk:
    """Awaits "quality" at first, unless ``awaits`` says otherwise. faults : number of a press to the problems of its
    first attempt.

    asked, screens : what came from the pages.
    """

    checklist: ClassVar = ("Forearm lies on its support", "Electrodes hold", "Force shows zero")

    def __init__(
        self, clock: Clock, awaits: str = "quality", faults: dict[int, tuple[tuple[str, str], ...]] | None = None
    ):
        self.clock, self._awaits, self._faults = clock, awaits, faults or {}
        self._lock = threading.RLock()
        self._number, self._told, self._told_s = 1, "", 0.0
        self._presses = list(PLAN)
        self._at = 0
        self._start_s: float | None = None
        self._done = dict.fromkeys(self.checklist, awaits == "start")
        self._signals = tuple(SignalView(muscle) for muscle in A_V)
        self._noise = np.random.default_rng(3)
        self._paused = False
        self._shown: tuple[object, ParticipantState] | None = None
        self.sequence_step = 1
        self._warnings: tuple[str, ...] = ()
        self.palette, self.sound, self.texts = "safe", False, TEXTS
        self.frozen_force: tuple[float, Direction] | None = None
        self.asked: list[Request] = []
        self.screens: list[ScreenReport] = []

    def participant(self) -> ParticipantState:
        with self._lock:
            command, press = self._command(), self._presses[self._at]
            key = command, self._at, self._paused, self.palette
            if self._shown is None or self._shown[0] != key:
                phase = [one for one in self._presses if one.phase == press.phase]
                texts = {name: getattr(self.texts, name) for name in self.texts.__dataclass_fields__}
                state = ParticipantState(
                    command, texts.get(command, texts["wait"]), press.phase, phase.index(press) + 1, len(phase),
                    FORCE_N, BAR_N, (1.0, 5.0), self.palette, self.sound, self.texts.language, texts,  # type: ignore[arg-type]
                    self.clock.now_s() + 24 if command == "pause" else None,
                )  # fmt: skip
                self._shown = key, state
            return self._shown[1]

    def force(self) -> ForceMessage:
        with self._lock:
            now_s = self.clock.now_s()
            self._advance(now_s)
            force_n, direction = self.frozen_force or self._force(now_s)
            number = int(200 * now_s) * self.sequence_step
            return ForceMessage(number, now_s, force_n, direction, "", self._command(), self._told_s)

    def operator(self) -> tuple[int, OperatorState]:
        with self._lock:
            self._advance(self.clock.now_s())
            press = self._presses[self._at]
            running = press if self._start_s is not None else None
            state = OperatorState(
                "P03", "palpation", self._command(), "" if self._start_s is not None else self._awaits,
                self._message(), press.specimen, press.phase, running, tuple(self._presses), dict(self._done),
                self._devices(), self._signals, self._fits(), self._warnings, self._commands(),
                "8 presses in sourcedata/sub-P03",
            )  # fmt: skip
            return self._number, state

    def traces(self, after: int) -> tuple[int, TraceMessage]:
        with self._lock:
            now = int(100 * self.clock.now_s())
            begin = after + 1 if after else max(0, now - 1000)
            times_s = [n / 100 for n in range(begin, now + 1)]
            forces = [self._force(time_s)[0] for time_s in times_s]
            levels = {m: [self._level(m, force) for force in forces] for m in A_V}
            high = {m: [v * (2 + 0.8 * abs(self._noise.standard_normal())) for v in vs] for m, vs in levels.items()}
            low = {m: [-v * (2 + 0.8 * abs(self._noise.standard_normal())) for v in vs] for m, vs in levels.items()}
            return now, TraceMessage(times_s, forces, levels, low, high)

    def ask(self, request: Request) -> str:
        with self._lock:
            if request.name not in self._commands():
                return f"{request.name} is not possible now."
            self.asked.append(request)
            self._number += 1
            getattr(self, f"_{request.name.replace('-', '_')}")(request)
            return ""

    def warn(self, *texts: str) -> None:
        with self._lock:
            self._warnings, self._number = texts, self._number + 1

    def screen(self, report: ScreenReport) -> None:
        self.screens.append(report)

    def _measure_rest(self, request: Request) -> None:
        self._signals = tuple(replace(signal, rest_v=REST_V) for signal in self._signals)
        self._awaits = "contraction"

    def _measure_contraction(self, request: Request) -> None:
        self._signals = tuple(replace(s, contraction_v=A_V[s.muscle] * 8, snr_db=38.0) for s in self._signals)
        self._awaits = "specimen"

    def _placed(self, request: Request) -> None:
        self._awaits, self._done = "checklist", dict.fromkeys(self.checklist, False)

    def _check(self, request: Request) -> None:
        self._done[request.item] = not self._done[request.item]
        self._awaits = "start" if all(self._done.values()) else "checklist"

    def _start(self, request: Request) -> None:
        self._start_s = self.clock.now_s()

    def _abort(self, request: Request) -> None:
        self._judged((("the press was aborted", "repeat it"),))

    def _accept(self, request: Request) -> None:
        self._decided("accept")

    def _repeat(self, request: Request) -> None:
        again = replace(self._presses[self._at], attempt=self._presses[self._at].attempt + 1, verdict="", problems=())
        self._decided("repeat", again)

    def _skip(self, request: Request) -> None:
        self._decided("skip")

    def _note(self, request: Request) -> None:
        at = max(i for i, press in enumerate(self._presses) if press.number == request.press)
        self._presses[at] = replace(self._presses[at], note=request.text)

    def _pause(self, request: Request) -> None:
        self._paused = True

    def _continue(self, request: Request) -> None:
        self._paused = False

    def _end(self, request: Request) -> None:
        self._awaits = "end"

    def _decided(self, decision: str, again: PressView | None = None) -> None:
        self._presses[self._at] = replace(self._presses[self._at], decision=decision)  # type: ignore[arg-type]
        if again is not None:
            self._presses.insert(self._at + 1, again)
        self._next()

    def _next(self) -> None:
        before = self._presses[self._at].specimen
        if self._at + 1 == len(self._presses):
            self._awaits = "end"
            return
        self._at += 1
        self._awaits = "start" if self._presses[self._at].specimen == before else "specimen"

    def _judged(self, problems: tuple[tuple[str, str], ...]) -> None:
        verdict = "rejected" if problems else "ok"
        self._presses[self._at] = replace(
            self._presses[self._at], verdict=verdict, problems=problems, peak_n=PEAK_N, load_s=LOAD_S * 6.5 / 7
        )
        self._start_s, self._number = None, self._number + 1
        if problems:
            self._awaits = "verdict"
        else:
            self._next()

    def _advance(self, now_s: float) -> None:
        whole_s = REACTION_S + LOAD_S + HELD_S + RELEASE_S + VERDICT_S
        if self._start_s is not None and now_s > self._start_s + whole_s:
            press = self._presses[self._at]
            self._judged(self._faults.get(press.number, ()) if press.attempt == 1 else ())
        command = self._command()
        self._number += command != self._told
        self._told, self._told_s = command, self._told_s if command == self._told else now_s

    def _force(self, time_s: float) -> tuple[float, Direction]:
        since_s = time_s - self._start_s - REACTION_S if self._start_s is not None else -1.0
        if since_s < 0 or since_s > LOAD_S + HELD_S + RELEASE_S:
            return 0.0, "none"
        if since_s < LOAD_S:
            return PEAK_N * since_s / LOAD_S, "rising"
        if since_s < LOAD_S + HELD_S:
            return PEAK_N, "steady"
        return PEAK_N * (1 - (since_s - LOAD_S - HELD_S) / RELEASE_S), "falling"

    def _command(self) -> str:  # type: ignore[return]
        if self._paused:
            return "pause"
        if self._start_s is None:
            return {"start": "ready", "verdict": "rest", "end": "done"}.get(self._awaits, "wait")
        since_s = self.clock.now_s() - self._start_s - REACTION_S
        if since_s < LOAD_S * FORCE_N[0] / PEAK_N:
            return "start"
        if since_s < LOAD_S:
            return "press"
        return "stop" if since_s < LOAD_S + HELD_S + RELEASE_S else "rest"

    def _commands(self) -> tuple[str, ...]:
        if self._paused:
            return ("continue", "note", "end")
        if self._start_s is not None:
            return ("abort", "note")
        own = {
            "quality": ("measure-rest",), "contraction": ("measure-rest", "measure-contraction"),
            "specimen": ("placed",), "checklist": ("check",), "start": ("start", "check"),
            "verdict": ("accept", "repeat", "skip"), "end": (),
        }[self._awaits]  # fmt: skip
        return (*own, "note", "pause", "end")

    def _message(self) -> str:
        said = {
            "quality": "Arm relaxed on its support, finger off the specimen.",
            "contraction": "Ask for the strongest contraction for three seconds.",
            "specimen": "Put the specimen on the sensor.", "checklist": "Go through the list.",
            "start": "Ready when the participant is.", "verdict": "The press has a fault. Repeat it?",
            "end": "All presses are done.",
        }  # fmt: skip
        return "The participant presses." if self._start_s is not None else said[self._awaits]

    def _devices(self) -> tuple[DeviceView, ...]:
        return (
            DeviceView("EMG", "good", "EMG comes as promised", 1000.0, 1000.02, 2e-4, 184_000, 0),
            DeviceView("Force", "good", "Force comes as promised", 1000.0, 999.97, 1e-4, 184_000, 0),
        )

    def _fits(self) -> tuple[SpecimenFit, ...]:
        left = {press.specimen for press in self._presses if not press.verdict and press.phase == "main"}
        whole = [s for s in ("S3", "S1") if s not in left]
        b_v = {"S3": (19e-6, 16e-6, 22e-6), "S1": (28e-6, 24e-6, 33e-6)}
        return tuple(SpecimenFit(specimen, 3, *b_v[specimen]) for specimen in whole)

    def _level(self, muscle: str, force_n: float) -> float:
        active = A_V[muscle] + B_V[muscle] * math.log(force_n) if force_n > 0.3 else 0.0
        return math.hypot(max(0.0, active), REST_V)
