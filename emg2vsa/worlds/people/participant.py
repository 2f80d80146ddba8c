"""An emulated participant: presses the specimen as the page tells it, late as people are, with mistakes on plan.

Finger, specimen and muscles are one world on one clock. The world goes on in steps of 5 ms: what the page shows then,
what the hand makes of it, where the finger is, and what the specimen's stiffness makes of that. Sensors ask for the
force between the steps, and for how active the muscles were.
"""

from __future__ import annotations

import json
import math
import threading
from collections import deque
from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from casr.atomic import write_text_atomic
from emg2vsa.session.views import ForceMessage, ParticipantState
from emg2vsa.worlds import VERSION
from emg2vsa.worlds.people.mistakes import OF_HAND, Mistake
from emg2vsa.worlds.people.person import Person, cocontraction_v, spread

FloatArray = NDArray[np.float64]

STEP_S = 0.005
HOVER_MM, APPROACH_MM_PER_S = 2.0, 20.0
"How far above the specimen the finger waits, and how fast it comes down."
SPEED_UP_S = 0.15
"Time in which the force begins to rise at its full rate."
WOBBLE_SHARE, WOBBLE_HZ = 0.25, (1.0, 3.0)
"Slow change of the rate: about 1 to 2 % of the force, and never a fall."
TREMOR_MM, TREMOR_HZ = 0.003, 9.0
"Amplitude and frequency of the finger's tremor (rms 0.02 N on the stiffest specimen)."
CORRECTION_S, CORRECTION = (0.15, 0.25), {"too fast": 0.7, "too slow": 1.4}
"After a word about the speed the rate changes by a factor, this much later."
MOST_N = 12.0
"Nobody presses harder without being told to."
PATIENCE_S = 1.5
"Time after which a participant who presses without START lifts the finger."
FAST, SLOW, ABORT_N, LATE_S, STAY_S = 4.0, 1 / 3, 4.0, 1.0, 6.0
DIP_AT_N, DIP_N_PER_S, DIP_S = 3.5, -3.0, 0.35
CONTRACTION_S = 0.3
"Time in which a maximum contraction is reached, and given up."
_KEPT_STEPS = 1 << 14
"History of 80 s, for sensors that are asked late."


class Page(Protocol):
    """What a participant sees; a `emg2vsa.session.desk.SessionDesk` is one."""

    def participant(self) -> ParticipantState:
        """The newest."""

    def force(self) -> ForceMessage:
        """The newest."""


class _Glance(NamedTuple):
    command: str = "wait"
    speed: str = ""
    phase: str = "main"
    press: int = 0


@dataclass
class TruePress:
    """What is true of a press. Times on the session's clock, s; NaN for what never happened.

    onset_s, stop_s : last rise of the true force through the lower force of the range before it first reaches the
    upper one, and that reach. attempt : from 1. mistake : planned kind, or "".
    """

    phase: str
    press: int
    attempt: int
    specimen: str
    mistake: str
    a_v: float
    b_v: float
    begun_s: float
    onset_s: float = math.nan
    stop_s: float = math.nan
    lifted_s: float = math.nan
    peak_force_n: float = 0.0


@dataclass(frozen=True)
class Affliction:
    """A time in which a sensor is wrong."""

    kind: str
    muscle: str
    start_s: float
    end_s: float = math.inf


class EmulatedParticipant:
    """A person at the table; call `watch` with the page and `place` with each specimen.

    Every method may be called from any thread.
    """

    def __init__(
        self, person: Person, *, mistakes: Iterable[Mistake] = (), range_n: tuple[float, float] = (0.5, 7.0)
    ) -> None:
        self.person = person
        self.presses: list[TruePress] = []
        self._range_n = range_n
        self._planned = list(mistakes)
        self.afflictions = [self._affliction(mistake, 0.0) for mistake in self._planned if mistake.press == 0]
        self._rng = np.random.default_rng(np.random.SeedSequence(person.seed[0], spawn_key=(*person.seed[1:], 0)))
        self._lock = threading.RLock()
        self._page: Page | None = None
        self._specimen, self._on_table = "", person.usual
        self._seen = _Glance()
        self._attempts: dict[tuple[str, int], int] = {}
        self._due: deque[tuple[float, Callable[[float], None]]] = deque()
        self._state = "rest"
        self._press: TruePress | None = None
        self._mistake = ""
        self._depth_mm = -HOVER_MM
        self._rate_n_per_s = self._since_s = self._dip_end_s = 0.0
        self._wobble = self._tremor_phase = 0.0
        self._wobble_hz, self._scale, self._effort = 2.0, 1.0, 0.0
        self._told_s = -math.inf
        self._steps = 0
        # one more step lies ahead, so that there is always something to interpolate to
        self._history = np.zeros((_KEPT_STEPS, 4))
        self._history[:, 1:3] = person.usual.a_v, person.usual.b_v
        self._advance_to(0)

    def watch(self, page: Page) -> None:
        """Begin to watch this page."""
        with self._lock:
            self._page = page

    def place(self, specimen: str) -> None:
        """Put a specimen under the finger; one that the study does not know is as the mean of the others."""
        with self._lock:
            self._specimen = specimen
            self._on_table = self.person.responses.get(specimen, self.person.usual)

    def advance(self, time_s: float) -> None:
        """Let the world go on to a time, s."""
        with self._lock:
            self._advance_to(math.ceil(time_s / STEP_S) + 1)

    def force_n(self, times_s: FloatArray) -> FloatArray:
        """(n,) true force, N, at rising times, s; the world goes on to the last of them."""
        return np.asarray(self._between(times_s - self.person.electromechanical_delay_s, times_s)[0])

    def cocontraction_v(self, times_s: FloatArray) -> FloatArray:
        """(n,) true mean rectified EMG, V, summed over muscles, at rising times, s; the world goes on to the last of
        them."""
        force_n, a_v, b_v, effort = self._between(times_s, times_s)
        pressing_v = cocontraction_v(force_n, a_v, b_v, self.person.lower_n, self.person.rest_v)
        return np.asarray(pressing_v + effort * (self.person.contraction_v - pressing_v))

    def afflicted(self, start_s: float, end_s: float) -> list[Affliction]:
        """What is wrong with the sensors at some time of an interval, s."""
        with self._lock:
            return [each for each in self.afflictions if each.start_s < end_s and each.end_s > start_s]

    def truth(self) -> dict[str, object]:
        """What is true, as plain data: the person's coefficients and every press so far."""
        with self._lock:
            responses = {name: response._asdict() for name, response in self.person.responses.items()}
            presses = [{k: _or_none(v) for k, v in asdict(press).items()} for press in self.presses]
            wrong = [{k: _or_none(v) for k, v in asdict(each).items()} for each in self.afflictions]
        return {
            "world": VERSION, "participant": self.person.name, "specimens": responses,
            "muscle_share": self.person.muscle_share, "presses": presses, "sensors_wrong": wrong,
        }  # fmt: skip

    def write_truth(self, path: Path) -> None:
        """The truth as JSON."""
        write_text_atomic(path, json.dumps(self.truth(), indent=2) + "\n")

    def _between(self, at_s: FloatArray, until_s: FloatArray) -> FloatArray:
        """(4, n) force, a, b and effort of a maximum contraction at some times."""
        if not at_s.size:
            return np.zeros((4, 0))
        with self._lock:
            self.advance(float(until_s[-1]))
            first, last = math.floor(at_s[0] / STEP_S), max(0, math.ceil(at_s[-1] / STEP_S))
            steps = np.arange(max(first, self._steps - _KEPT_STEPS + 1, 0), min(last, self._steps) + 1)
            kept = self._history[steps % _KEPT_STEPS].T
            return np.array([np.interp(at_s, steps * STEP_S, values) for values in kept])

    # one step

    def _advance_to(self, step: int) -> None:
        while self._steps < step:
            self._steps += 1
            time_s = self._steps * STEP_S
            self._look(time_s)
            while self._due and self._due[0][0] <= time_s:
                self._due.popleft()[1](time_s)
            force_n = self._move(time_s)
            a_v, b_v = self._on_table.a_v * self._scale, self._on_table.b_v * self._scale
            self._history[self._steps % _KEPT_STEPS] = force_n, a_v, b_v, self._contraction()
            if self._press is not None:
                self._keep_truth(time_s, force_n)

    def _look(self, time_s: float) -> None:
        if self._page is None:
            return
        state, force = self._page.participant(), self._page.force()
        # the state comes when it changes and the force all the time: a command is seen in whichever is newer
        glance = _Glance(state.command, force.speed, state.phase, state.press)
        before, self._seen = self._seen, glance
        if (glance.command, glance.press, glance.phase) != (before.command, before.press, before.phase):
            self._obey(glance, before, time_s)
        if glance.speed in CORRECTION and self._state == "load" and time_s - self._told_s > 0.5 and not self._mistake:
            self._told_s = time_s
            factor = CORRECTION[glance.speed]
            self._later(time_s + self._rng.uniform(*CORRECTION_S), lambda _: self._change_rate(factor))

    def _obey(self, glance: _Glance, before: _Glance, time_s: float) -> None:
        beginning = glance.command in ("start", "press")
        if glance.command == "ready" or (beginning and before.command not in ("ready", "start", "press")):
            self._meet(glance, time_s)
        reaction_s = self._rng.uniform(*self.person.reaction_s)
        if glance.phase == "quality" or self._state == "contract":
            if beginning != (self._state == "contract"):
                state = "contract" if beginning else "rest"
                self._later(time_s + reaction_s, lambda now_s: self._enter(state, now_s))
        elif glance.command == "ready" and self._mistake == "early":
            self._later(time_s + reaction_s, self._begin)
        elif beginning:
            if self._state == "rest" and not self._due:
                self._later(time_s + reaction_s, self._begin)
        elif self._state in ("approach", "load", "hold") and glance.command != "ready":
            late_s = {"overshoot": LATE_S, "never-lifts": 0.0}.get(self._mistake, 0.0)
            self._later(time_s + reaction_s + late_s, self._stop)

    def _meet(self, glance: _Glance, time_s: float) -> None:
        """The next press is near: its planned mistake, and an end of the last one's."""
        self._mistake = ""
        self.afflictions = [replace(each, end_s=min(each.end_s, time_s)) for each in self.afflictions]
        for mistake in self._planned_for(glance):
            self._mistake = mistake.kind
            if mistake.kind not in OF_HAND:
                self.afflictions.append(self._affliction(mistake, time_s))

    def _affliction(self, mistake: Mistake, time_s: float) -> Affliction:
        return Affliction(mistake.kind, mistake.muscle or next(iter(self.person.muscle_share)), time_s)

    def _planned_for(self, glance: _Glance) -> list[Mistake]:
        return [m for m in self._planned if (m.phase, m.press) == (glance.phase, glance.press)]

    def _begin(self, time_s: float) -> None:
        if self._state != "rest":
            return
        rng, seen = self._rng, self._seen
        for mistake in self._planned_for(seen):
            self._planned.remove(mistake)  # another attempt at this press is a good one
        self._scale = float(spread(rng, self.person.repetition_sd, 1)[0])
        self._rate_n_per_s = rng.uniform(*self.person.rise_n_per_s)
        self._rate_n_per_s *= {"too-fast": FAST, "too-slow": SLOW}.get(self._mistake, 1.0)
        self._wobble_hz, self._wobble = rng.uniform(*WOBBLE_HZ), rng.uniform(0, math.tau)
        self._tremor_phase = rng.uniform(0, math.tau)
        attempt = self._attempts[seen.phase, seen.press] = self._attempts.get((seen.phase, seen.press), 0) + 1
        response = self._on_table
        self._press = TruePress(
            seen.phase, seen.press, attempt, self._specimen, self._mistake,
            response.a_v * self._scale, response.b_v * self._scale, time_s,
        )  # fmt: skip
        self.presses.append(self._press)
        self._due.clear()
        self._dip_end_s = 0.0
        self._enter("approach", time_s)

    def _stop(self, time_s: float) -> None:
        if self._mistake == "never-lifts" and self._state == "load":
            self._enter("hold", time_s)
        elif self._state in ("approach", "load"):
            self._enter("release", time_s)

    def _move(self, time_s: float) -> float:
        """Move the finger by a step; the force it then has."""
        kappa = self._on_table.stiffness_n_per_mm
        force_n = self._depth_mm * kappa
        if self._state == "approach":
            self._depth_mm = min(0.0, self._depth_mm + APPROACH_MM_PER_S * STEP_S)
            if self._depth_mm == 0.0:
                self._enter("load", time_s)
        elif self._state == "load":
            self._depth_mm += self._rising(time_s, force_n) * STEP_S / kappa
            untold = self._seen.command not in ("start", "press", "stop")
            most_n = ABORT_N if self._mistake == "aborted" else MOST_N
            if force_n >= most_n or (untold and time_s - self._since_s > PATIENCE_S):
                self._enter("release", time_s)
        elif self._state == "hold" and time_s - self._since_s > STAY_S:
            self._enter("release", time_s)
        elif self._state == "release":
            # in the air the finger goes up as it came down
            speed = self.person.release_n_per_s / kappa if self._depth_mm > 0 else APPROACH_MM_PER_S
            self._depth_mm = max(-HOVER_MM, self._depth_mm - speed * STEP_S)
            if self._depth_mm == -HOVER_MM:
                self._enter("rest", time_s)
        if self._depth_mm <= 0:
            return 0.0
        tremor_mm = TREMOR_MM * math.sin(math.tau * TREMOR_HZ * time_s + self._tremor_phase)
        return max(0.0, self._depth_mm + tremor_mm) * kappa

    def _rising(self, time_s: float, force_n: float) -> float:
        """Rate of the force, N/s."""
        if self._mistake == "dips" and self._dip_end_s == 0.0 and force_n >= DIP_AT_N:
            self._dip_end_s = time_s + DIP_S
        if time_s < self._dip_end_s:
            return DIP_N_PER_S
        begun = min(1.0, (time_s - self._since_s) / SPEED_UP_S)
        wobble = 1 + WOBBLE_SHARE * math.sin(math.tau * self._wobble_hz * time_s + self._wobble)
        return self._rate_n_per_s * begun * wobble

    def _contraction(self) -> float:
        """Effort of a maximum contraction, 0 to 1, a step later."""
        way = STEP_S / CONTRACTION_S * (1 if self._state == "contract" else -1)
        self._effort = min(1.0, max(0.0, self._effort + way))
        return self._effort

    def _keep_truth(self, time_s: float, force_n: float) -> None:
        press = self._press
        assert press is not None
        before_n = float(self._history[(self._steps - 1) % _KEPT_STEPS, 0])
        lower_n, upper_n = self._range_n
        press.peak_force_n = max(press.peak_force_n, force_n)
        felt_s = time_s + self.person.electromechanical_delay_s
        if math.isnan(press.stop_s):
            if before_n < lower_n <= force_n:
                press.onset_s = felt_s - STEP_S * (force_n - lower_n) / (force_n - before_n)
            if before_n < upper_n <= force_n:
                press.stop_s = felt_s - STEP_S * (force_n - upper_n) / (force_n - before_n)
        if self._state == "rest":
            press.lifted_s = felt_s
            self._press = None

    def _enter(self, state: str, time_s: float) -> None:
        self._state, self._since_s = state, time_s

    def _change_rate(self, factor: float) -> None:
        self._rate_n_per_s *= factor

    def _later(self, time_s: float, act: Callable[[float], None]) -> None:
        self._due.append((time_s, act))
        self._due = deque(sorted(self._due, key=lambda each: each[0]))


def _or_none(value: object) -> object:
    return None if isinstance(value, float) and not math.isfinite(value) else value
