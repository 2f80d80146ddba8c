"""The runs of an experiment: which specimens, angles and conditions, and how each press goes (paper, section V)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import field
from typing import TYPE_CHECKING, Annotated, Literal, NamedTuple

from emg2vsa.errors import ScheduleError
from emg2vsa.random_order import random_numbers, shuffled
from emg2vsa.rig.plan import RIGID, Condition, RunPlan
from emg2vsa.settings import Ge, Gt, Le, MinLen
from emg2vsa.settings_class import settings_class

if TYPE_CHECKING:
    from emg2vsa.schedules import Schedule

_OF_A_PRESS = "f_max_n", "f_contact_n", "contact_s", "ramp_mm_per_s", "travel_mm", "lead_s", "pause_s"
"""Keys of an experiment that its plans take over."""
Angles = tuple[Annotated[float, Ge(0)], ...]


def _paper_angles() -> dict[Condition, Angles]:
    # constant stiffness was pressed along the normal only (paper, section V)
    return {
        "high-stiffness": (0.0, 30.0, 45.0),
        "modular": (0.0, 30.0, 45.0),
        "constant-min": (0.0,),
        "constant-mean": (0.0,),
        "constant-max": (0.0,),
    }


class Run(NamedTuple):
    """One run: a specimen at an angle, in degrees, under a condition; ``mounting`` counts from 1."""

    specimen: str
    angle_deg: float
    condition: Condition
    mounting: int = 1

    @property
    def name(self) -> str:
        """Name of the run and of its folder."""
        return run_name(*self)


@settings_class
class ExperimentSettings:
    """What is pressed, and how."""

    specimens: Annotated[tuple[str, ...], MinLen(1)]
    "Names, as the schedules have them."
    angles_deg: dict[Condition, Angles] = field(default_factory=_paper_angles)
    "Angles between probe and surface normal for each condition run; omitted: the paper's runs, rigid motor included."
    repetitions: Annotated[int, Ge(1), Le(999)] = 10
    "Presses of each run."
    mountings: Annotated[int, Ge(1), Le(99)] = 1
    """How often each specimen is mounted anew at each angle under each condition. Each mounting is a run of its own:
    presses of one mounting share its errors, so that only several mountings tell an effect from them."""
    schedule_of: dict[str, str] = field(default_factory=dict)
    """Specimen to the specimen whose schedules press it, where these are not its own: swapped, or one for all. This is
    the control that tells what stiffness does from what a schedule knows of its specimen (docs/how-to/controls.md)."""
    order: Literal["random", "listed"] = "random"
    """Order of the runs: random, so that what drifts falls on all of them alike; or listed: the first mounting of all,
    then the second, and within it by condition, angle and specimen as they stand here."""
    seed: Annotated[int, Ge(0)] = 0
    "Seed of the random order: the same seed and the same runs give the same order for ever."
    f_max_n: Annotated[float, Gt(0)] = 7.0
    "The press turns back here."
    lead_s: Annotated[float, Ge(0), Le(0.1)] = 0.0
    """How long before the force, as it grows, would reach f_max_n the press turns back. Filter, bus and motors are
    late: with the springs of the qbmove maker pro the emulated force goes 0.4 (S5) to 1.3 N (S1) beyond f_max_n. With
    0.04 presses end within 0.45 N of it, and one may end up to 0.1 N short. Stiffer springs (qbmove advanced) go
    further. 0 turns back at f_max_n, as the paper says."""
    f_contact_n: Annotated[float, Gt(0)] = 0.5
    "Force of first contact."
    contact_s: Annotated[float, Ge(0), Le(10)] = 0.05
    "How long the force must stay at f_contact_n."
    ramp_mm_per_s: Annotated[float, Gt(0)] = 5.0
    "Speed of the probe."
    travel_mm: Annotated[float, Gt(0)] = 15.0
    "Length of the ramp."
    pause_s: Annotated[float, Ge(0), Le(3600)] = 2.0
    "Between two presses."
    stiffness_n_per_mm: dict[str, Annotated[float, Gt(0)]] = field(default_factory=dict)
    """Specimen to its stiffness by plate indentation, N/mm: it tells the largest force to expect, and how deep a press
    may go. Of a specimen not named here that of [emulated] is taken."""

    def all_runs(self) -> tuple[Run, ...]:
        """Every run, as listed: the first mounting of all, then the second."""
        return tuple(
            Run(specimen, angle_deg, condition, mounting)
            for mounting in range(1, self.mountings + 1)
            for condition, angles in self.angles_deg.items()
            for angle_deg in angles
            for specimen in self.specimens
        )

    def ordered_runs(self) -> tuple[Run, ...]:
        """Every run, in the order in which they are to be done."""
        listed = self.all_runs()
        return tuple(shuffled(listed, random_numbers(f"{self.seed}\nruns"))) if self.order == "random" else listed


@settings_class
class PlateSettings:
    """Indentation of specimens by a flat plate on the rigid motor, for their stiffness (paper, section IV.B)."""

    trials: Annotated[int, Ge(1), Le(999)] = 5
    "Trials of each specimen."
    f_max_n: Annotated[float, Gt(0)] = 5.0
    "The plate turns back here."
    f_contact_n: Annotated[float, Gt(0)] = 0.3
    "Force of first contact."
    ramp_mm_per_s: Annotated[float, Gt(0)] = 1.0
    "Speed of the plate."
    pause_s: Annotated[float, Ge(0), Le(3600)] = 5.0
    "Between two trials, for a viscous specimen to come back."


def plate_plan(plate: PlateSettings, experiment: ExperimentSettings, specimen: str) -> RunPlan:
    """The plan of all trials of one specimen, along its normal and without a schedule."""
    own = {name: getattr(plate, name) for name in ("f_max_n", "f_contact_n", "ramp_mm_per_s", "pause_s")}
    own |= {name: getattr(experiment, name) for name in ("contact_s", "travel_mm")}
    return RunPlan(specimen, 0.0, RIGID, plate.trials, None, plate=True, **own)


def run_name(specimen: str, angle_deg: float, condition: str, mounting: int = 1) -> str:
    """Name of a run and of its folder, angle in degrees; that of the first mounting names no mounting."""
    return f"{specimen}_{angle_deg:g}_{condition}" + (f"_mounting-{mounting}" if mounting > 1 else "")


def plan_of(
    experiment: ExperimentSettings,
    run: Run,
    schedules: Sequence[Schedule],
    emulated_n_per_mm: Mapping[str, float] | None = None,
) -> RunPlan:
    """The plan of one run (paper, section V). ScheduleError where the specimen has no schedule for its condition.

    ``emulated_n_per_mm`` : stiffness, N/mm, of specimens on the emulated bench, for those that the experiment does not
        name.
    """
    other = experiment.schedule_of.get(run.specimen)
    schedule = None if run.condition == RIGID else schedule_for(schedules, other or run.specimen, run.condition)
    known = dict(emulated_n_per_mm or {}) | experiment.stiffness_n_per_mm
    own = known.pop(run.specimen, None)
    return RunPlan(
        run.specimen, run.angle_deg, run.condition, experiment.repetitions, schedule,
        mounting=run.mounting, schedule_from=other,
        stiffness_n_per_mm=own, others_n_per_mm=known,
        **{name: getattr(experiment, name) for name in _OF_A_PRESS},
    )  # fmt: skip


def schedule_for(schedules: Sequence[Schedule], specimen: str, condition: str) -> Schedule:
    """Schedule of a specimen and condition. ScheduleError where there is none."""
    for schedule in schedules:
        if (schedule.specimen, schedule.condition) == (specimen, condition):
            return schedule
    there = ", ".join(sorted({schedule.specimen for schedule in schedules})) or "none"
    wanted = "a schedule for every specimen of the experiment"
    do = "Export it with emg2vsa schedule, or take the specimen out of rig.toml."
    raise ScheduleError(f"{specimen}, {condition}", wanted=wanted, found=f"schedules of {there}", do=do)
