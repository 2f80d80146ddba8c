"""How long a stiffness step takes: from the force sample that crosses its edge to the command, and to the motors."""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from emg2vsa.actuator import Springs

from emg2vsa.devices.clock import Clock
from emg2vsa.devices.protocols import Actuator, Measurements
from emg2vsa.rig.record.run_log import Row

SETTLED = 0.9
"Part of a step at which the motors count as there."
MOVING = 0.1


@dataclass
class TimedActuator:
    """An actuator with the time of every command and of every measurement's arrival, s."""

    actuator: Actuator
    clock: Clock
    commands: list[tuple[float, int]] = field(default_factory=list)
    "Time when sent, preset in ticks."
    presets: list[tuple[float, float]] = field(default_factory=list)
    "Time when measured, preset that the motors have, ticks."

    def activate(self) -> None:
        self.actuator.activate()

    def deactivate(self) -> None:
        self.actuator.deactivate()

    def is_active(self) -> bool:
        return self.actuator.is_active()

    def set_position_stiffness(self, position_ticks: int, preset_ticks: int) -> None:
        self.actuator.set_position_stiffness(position_ticks, preset_ticks)
        self.commands.append((self.clock.now_s(), preset_ticks))

    def position_ticks(self) -> float:
        return self.actuator.position_ticks()

    def measurements(self) -> Measurements:
        at = self.actuator.measurements()
        self.presets.append((self.clock.now_s(), (at.motor_1 - at.motor_2) / 2))
        return at

    def currents_ma(self) -> tuple[int, int]:
        return self.actuator.currents_ma()

    def current_limit_ma(self) -> float:
        return self.actuator.current_limit_ma()

    @property
    def springs(self) -> Springs | None:
        """Of the actuator."""
        return self.actuator.springs


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
        low, high = before.preset_ticks, row.preset_ticks
        if row.phase != "load" or low is None or high is None or high <= low:
            continue
        start_s = row.time_s
        found.command_s.append(float(sent_s[np.searchsorted(sent_s, start_s)]) - start_s)
        seen = slice(np.searchsorted(seen_s, start_s), np.searchsorted(seen_s, over_s.get(row.repetition, start_s)))
        for latencies, part in ((found.moving_s, MOVING), (found.settled_s, SETTLED)):
            there = np.flatnonzero(presets[seen] >= low + part * (high - low))
            latencies.append(float(seen_s[seen][there[0]]) - start_s if there.size else np.nan)
    return found
