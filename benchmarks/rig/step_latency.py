"""How long a stiffness step takes: from the force sample that crosses its edge to the command, and to the motors."""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from emg2vsa.devices.clock import Clock
from emg2vsa.devices.protocols import Actuator, Joint, LogColumns, Measurements
from emg2vsa.rig.record.run_log import Row

SETTLED = 0.9
"Part of a step at which the motors count as there."
MOVING = 0.1


@dataclass
class TimedActuator:
    """An actuator with the time of every command and of every measurement's arrival, s."""

    actuator: Actuator
    clock: Clock
    commands: list[tuple[float, float]] = field(default_factory=list)
    "Time when sent, preset."
    presets: list[tuple[float, float]] = field(default_factory=list)
    "Time when measured, preset that the motors have, degrees."

    def activate(self) -> None:
        self.actuator.activate()

    def deactivate(self) -> None:
        self.actuator.deactivate()

    def is_active(self) -> bool:
        return self.actuator.is_active()

    def command(self, position_deg: float, preset: float) -> None:
        self.actuator.command(position_deg, preset)
        self.commands.append((self.clock.now_s(), preset))

    def position_deg(self) -> float:
        return self.actuator.position_deg()

    def measurements(self) -> Measurements:
        at = self.actuator.measurements()
        self.presets.append((self.clock.now_s(), (at.motors_deg[0] - at.motors_deg[1]) / 2))
        return at

    def currents_a(self) -> tuple[float, ...]:
        return self.actuator.currents_a()

    def current_limit_a(self) -> float:
        return self.actuator.current_limit_a()

    @property
    def joint(self) -> Joint | None:
        """Of the actuator."""
        return self.actuator.joint

    @property
    def columns(self) -> LogColumns:
        """Of the actuator."""
        return self.actuator.columns


@dataclass(frozen=True)
class StepLatency:
    """Of every step up during loading, s; not a number where the press was over before."""

    command_s: list[float]
    moving_s: list[float]
    settled_s: list[float]


def step_latency(rows: list[Row], timed: TimedActuator) -> StepLatency:
    """From the start of the turn that read the force to the command sent, and to motors seen at a part of the step.

    Steps follow each other faster than motors do, so a step may be seen after the command of the next.
    """
    found = StepLatency([], [], [])
    sent_s = np.array([time_s for time_s, _ in timed.commands])
    seen_s, presets = np.array(timed.presets).T
    over_s = {row.repetition: row.time_s for row in rows if row.phase == "retract"}
    for before, row in pairwise(rows):
        low, high = before.preset, row.preset
        if row.phase != "load" or low is None or high is None or high <= low:
            continue
        start_s = row.time_s
        found.command_s.append(float(sent_s[np.searchsorted(sent_s, start_s)]) - start_s)
        seen = slice(np.searchsorted(seen_s, start_s), np.searchsorted(seen_s, over_s.get(row.repetition, start_s)))
        for latencies, part in ((found.moving_s, MOVING), (found.settled_s, SETTLED)):
            there = np.flatnonzero(presets[seen] >= low + part * (high - low))
            latencies.append(float(seen_s[seen][there[0]]) - start_s if there.size else np.nan)
    return found
