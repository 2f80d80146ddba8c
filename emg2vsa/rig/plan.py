"""The plan of a run: one specimen, angle and condition, pressed a number of times. Data; ``execute`` carries it out."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

from emg2vsa.settings import RIGID, Condition

if TYPE_CHECKING:
    from emg2vsa.schedules import Schedule

__all__ = ["RIGID", "Condition", "RunPlan"]


@dataclass(frozen=True, eq=False)
class RunPlan:
    """What to do to one specimen (paper, section V)."""

    specimen: str
    angle_deg: float
    condition: Condition
    repetitions: int
    schedule: Schedule | None
    "Force to stiffness; None under high-stiffness, where a rigid motor presses."
    f_max_n: float
    "The press turns back here."
    f_contact_n: float = 0.5
    contact_s: float = 0.05
    "The probe rests until the force has stayed at ``f_contact_n`` for so long: one noisy sample is no contact."
    ramp_mm_per_s: float = 5.0
    travel_mm: float = 15.0
    "Length of the ramp."
    lead_s: float = 0.0
    "The press turns back so long before the force, as it grows, would reach F_max."
    pause_s: float = 2.0
    "Between two repetitions."
    plate: bool = False
    "A flat plate presses, in place of the dome of the tactile sensor: for the specimen's own stiffness."
    schedule_from: str | None = None
    "Specimen whose schedule presses this one on purpose; None: its own."
    mounting: int = 1
    "Which of the times that the specimen was mounted for this run, from 1."
    order: int | None = None
    "Place of the run in the sequence of its experiment, from 1; None where it was asked for alone."
    stiffness_n_per_mm: float | None = None
    "Stiffness of the specimen, by plate indentation; None where it is not known."
    motor_a_per_n: float | None = None
    "Current that a rigid motor draws for a newton, by a reference that was pressed; None where none holds."
    others_n_per_mm: Mapping[str, float] = field(default_factory=dict)
    "Of other specimens, by name: which one a press is like that is not like this one's."

    @property
    def witnessed(self) -> bool:
        """Whether anything but the sensor tells its force: springs, the motor's current, or the named specimen under
        the dome."""
        specimen = not self.plate and self.stiffness_n_per_mm is not None
        return self.condition != RIGID or self.motor_a_per_n is not None or specimen

    def step_at(self, force_n: float) -> int:
        """Index of the force step that ``force_n``, N, is in; below the first edge the first, above the last the
        last."""
        if self.schedule is None:
            return 0
        edges = self._edges_n
        return min(max(bisect_right(edges, force_n) - 1, 0), len(edges) - 2)

    def preset(self, step: int, full_preset: float) -> float:
        """Stiffness preset of a force step, share of ``full_preset``; 0 for a rigid motor.

        A schedule that was made for another full preset asks for the same stiffness, and so for another share."""
        return 0.0 if self.schedule is None else self._presets[step] / full_preset

    def presets(self, full_preset: float) -> list[float]:
        """Presets of all force steps; only 0 for a rigid motor."""
        return [0.0] if self.schedule is None else [preset / full_preset for preset in self._presets]

    @cached_property
    def _edges_n(self) -> list[float]:
        assert self.schedule is not None
        edges: list[float] = self.schedule.step_force_n.tolist()
        return edges

    @cached_property
    def _presets(self) -> list[float]:
        """Presets in the joint's own unit."""
        assert self.schedule is not None
        presets: list[float] = (self.schedule.preset * self.schedule.limits.full_preset).tolist()
        return presets
