"""What the page shows at one moment: the newest rows as curves, and where the run is."""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Sequence
from dataclasses import dataclass, field

from emg2vsa.live.kappa_view import KappaView
from emg2vsa.live.run_facts import Ending, RunFacts
from emg2vsa.rig.record.run_log import Row
from emg2vsa.rig.rig_settings import RigSettings

WINDOW_S = 15.0
"""Length of the curves."""
Column = list[float | None]


@dataclass(frozen=True)
class Curves:
    """New samples, (n,) each, oldest first; None where a turn of the loop had none."""

    time_s: Column = field(default_factory=list)
    raw_n: Column = field(default_factory=list)
    filtered_n: Column = field(default_factory=list)
    preset: Column = field(default_factory=list)
    "Commanded, in the unit of the run's full preset."
    measured_preset: Column = field(default_factory=list)
    "Half the difference of the two motors, equation (8); None of one motor."
    depth_mm: Column = field(default_factory=list)
    "Commanded."
    shaft_mm: Column = field(default_factory=list)
    "Measured at the output shaft, behind the springs."


@dataclass(frozen=True)
class Snapshot:
    """One moment."""

    folder: str
    "That is followed."
    run: RunFacts | None = None
    "None while there is no run."
    curves: Curves = field(default_factory=Curves)
    phase: str = ""
    repetition: int = 0
    "From 1; 0 before the first press."
    presses_done: int = 0
    largest_n: float = 0.0
    "Largest force of the run along push_axis, of either sign, N."
    largest_across_n: float = 0.0
    "Largest force of the run across it."
    turns: int = 0
    "Of the control loop, since somebody watches."
    late_turns: int = 0
    "Of these."
    latest_ms: float = 0.0
    "Largest delay of one of these."
    frame: str = ""
    "Changes with every frame; empty when there is none."
    age_s: float | None = None
    "Since the log last grew; None without a log."
    kappa: KappaView | None = None
    "None where presses are not judged while they go on."
    stop_requested: bool = False
    ended: Ending | None = None
    trouble: str = ""
    "Why the folder cannot be shown."
    anew: bool = False
    "The curves are all there are, and not what came since the last moment."


def curves_of(rows: Sequence[Row], rig: RigSettings) -> Curves:
    """Curves of the rows within ``WINDOW_S`` of the last."""
    recent = [row for row in rows if row.time_s >= rows[-1].time_s - WINDOW_S]
    return Curves(
        [round(row.time_s, 4) for row in recent],
        [_rounded(row.force_n) for row in recent],
        [_rounded(row.filtered_n) for row in recent],
        [_rounded(row.preset) for row in recent],
        [_half_difference(row) for row in recent],
        [_depth(row.position_deg, rig) for row in recent],
        [_depth(row.at and row.at.shaft_deg, rig) for row in recent],
    )


def joined(before: Curves, after: Curves) -> Curves:
    """Both, as far as they are within ``WINDOW_S`` of the last sample."""
    columns = {name: [*values, *getattr(after, name)] for name, values in vars(before).items()}
    times_s = columns["time_s"]
    first = bisect_left(times_s, times_s[-1] - WINDOW_S) if times_s else 0
    return Curves(**{name: values[first:] for name, values in columns.items()})


def _half_difference(row: Row) -> float | None:
    if row.at is None or len(row.at.motors_deg) < 2:
        return None
    return _rounded((row.at.motors_deg[0] - row.at.motors_deg[1]) / 2)


def _depth(position_deg: float | None, rig: RigSettings) -> float | None:
    return None if position_deg is None else round(rig.depth_at(position_deg), 3)


def _rounded(value: float | None) -> float | None:
    return None if value is None or not math.isfinite(value) else round(value, 3)
