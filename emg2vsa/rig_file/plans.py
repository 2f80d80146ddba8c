"""The runs of a rig file: their plans, and their order, which is drawn once and kept in the folder of the runs."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal, get_args

from casr.atomic import write_text_atomic
from emg2vsa.errors import DataError, ScheduleError, SettingError
from emg2vsa.rig.experiment import ExperimentSettings, Run, plan_of
from emg2vsa.rig.plan import RIGID, RunPlan
from emg2vsa.rig_file.tables import RigFile
from emg2vsa.schedule_files import read_json
from emg2vsa.schedules import Schedule
from emg2vsa.study_file.problems import nearest

__all__ = ["Run", "chosen_runs", "plans_of", "read_schedules"]


def chosen_runs(
    file: RigFile,
    specimens: Sequence[str] = (),
    angles_deg: Sequence[float] = (),
    conditions: Sequence[str] = (),
    mountings: Sequence[int] = (),
) -> tuple[Run, ...]:
    """Runs of the experiment with these specimens, angles (degrees), conditions and mountings, in order; none given is
    all.

    SettingError : a name or number that the experiment has not, or no run with all of them.
    """
    keys = {
        run: {
            "specimen": run.specimen,
            "angle": f"{run.angle_deg:g}",
            "condition": run.condition,
            "mounting": str(run.mounting),
        }
        for run in file.experiment.all_runs()
    }
    asked = {
        "specimen": specimens,
        "angle": [f"{angle:g}" for angle in angles_deg],
        "condition": conditions,
        "mounting": [str(mounting) for mounting in mountings],
    }
    for what, names in asked.items():
        known = list(dict.fromkeys(of_run[what] for of_run in keys.values()))
        for name in names:
            if name not in known:
                do = nearest(
                    name,
                    known if what in ("specimen", "condition") else (),
                    "Add it to [experiment], or choose another.",
                )
                raise SettingError(f"{file.path}, {what}", wanted=", ".join(known), found=name, do=do)
    chosen = tuple(
        run for run, of_run in keys.items() if all(of_run[what] in names for what, names in asked.items() if names)
    )
    if not chosen:
        choice = ", ".join(f"{what} {' or '.join(names)}" for what, names in asked.items() if names)
        raise SettingError(file.path, wanted="a run of the experiment", found=choice, do="See [experiment.angles_deg].")
    return chosen


def plans_of(file: RigFile, runs: Sequence[Run], repetitions: int | None = None) -> tuple[RunPlan, ...]:
    """The plans of ``runs``, with the schedules in the file's folder. ``repetitions``: instead of the experiment's.

    ScheduleError : a schedule is absent, not as it was exported, or for another model of actuator.
    """
    schedules = read_schedules(file, runs, file.experiment.schedule_of)
    experiment = replace(file.experiment, repetitions=repetitions or file.experiment.repetitions)
    emulated_n_per_mm = file.emulated.stiffness_n_per_mm if file.emulated else None
    return tuple(plan_of(experiment, run, schedules, emulated_n_per_mm) for run in runs)


def read_schedules(file: RigFile, runs: Sequence[Run], schedule_of: Mapping[str, str]) -> tuple[Schedule, ...]:
    """The schedules that ``runs`` need, those of ``schedule_of`` instead of a specimen's own.

    ScheduleError names all files that are absent, or the first that is no good or for another actuator. SettingError :
    the full preset of the actuator is not known.
    """
    folder, pressed = file.schedules, [run for run in runs if run.condition != RIGID]
    stems = dict.fromkeys(f"{schedule_of.get(run.specimen, run.specimen)}_{run.condition}" for run in pressed)
    paths = [folder / f"{stem}.json" for stem in stems]
    absent = [path.name for path in paths if not path.is_file()]
    if absent:
        raise ScheduleError(
            folder,
            wanted=f"a schedule for every specimen and condition, {len(paths)} files",
            found=f"no {', '.join(absent[:3])}" + (f" and {len(absent) - 3} more" if len(absent) > 3 else ""),
            do="Export them with emg2vsa schedule STUDY, or correct [experiment].",
        )
    schedules = tuple(map(read_json, paths))
    if schedules and (key := file.devices.actuator.unmeasured):
        do = "Measure it: emg2vsa rig commission writes it into the rig file."
        raise SettingError(f"{file.path}, actuator.{key}", wanted="a measured stiffness", found="none", do=do)
    do = "Set [schedule] actuator of the study to this one and export again"
    for one in schedules:
        file.check_actuator(one.limits.actuator, f"schedule of {one.specimen}, {one.condition}, limits.actuator", do)
    return schedules


ORDER_FILE = "order.json"
Order = Literal["random", "listed"]


@dataclass(frozen=True)
class RunOrder:
    """Runs in their order. seed : that they were drawn with; None of runs as listed."""

    order: Order
    seed: int | None
    runs: tuple[Run, ...]

    def __str__(self) -> str:
        return _told(self.order, self.seed)

    def place(self, run: Run) -> int:
        """Place from 1."""
        return self.runs.index(run) + 1


def ordered(experiment: ExperimentSettings, order: Order | None = None, seed: int | None = None) -> RunOrder:
    """The runs in the order that is asked for, else that of the experiment; likewise its seed. SettingError : there is
    no such order, or the seed is no whole number."""
    if order not in (None, *get_args(Order)):
        listed = " or ".join(get_args(Order))
        raise SettingError("order", wanted=listed, found=repr(order), do="Choose one of them.")
    if not isinstance(seed, int | None):
        raise SettingError("seed", wanted="a whole number", found=repr(seed), do="Choose a whole number.")
    settings = replace(experiment, order=order or experiment.order, seed=experiment.seed if seed is None else seed)
    return RunOrder(settings.order, settings.seed if settings.order == "random" else None, settings.ordered_runs())


def run_order(root: Path, experiment: ExperimentSettings, order: Order | None, seed: int | None) -> RunOrder:
    """The order kept in ``root``; without one that of `ordered`, which is then kept.

    order, seed : as asked for; None takes what is kept, else what the experiment says.

    DataError : another order or seed is kept, its file is of another form, or the experiment has other runs by now.
    """
    path, runs = root / ORDER_FILE, experiment.all_runs()
    if not path.exists():
        drawn = ordered(experiment, order, seed)
        root.mkdir(parents=True, exist_ok=True)
        write_text_atomic(path, json.dumps(_document(drawn), indent=1) + "\n")
        return drawn
    kept = _read(path)
    asked = order or kept.order, kept.seed if seed is None else seed
    if asked != (kept.order, kept.seed):
        do = "Leave out --order and --seed to go on, or choose another folder with --out."
        raise DataError(path, wanted=f"order {_told(*asked)}", found=f"{kept}, begun", do=do)
    if set(kept.runs) != set(runs):
        do = "Choose another folder with --out, or undo the change of [experiment]."
        raise DataError(
            path, wanted=f"the {len(runs)} runs of the rig file", found=f"{len(kept.runs)}, not the same", do=do
        )
    return kept


def _told(order: str, seed: int | None) -> str:
    return order if seed is None else f"{order} with seed {seed}"


def _document(drawn: RunOrder) -> dict[str, Any]:
    return {
        "order": drawn.order, "seed": drawn.seed, "runs": [run._asdict() for run in drawn.runs]
    }  # fmt: skip


def _read(path: Path) -> RunOrder:
    try:
        kept = json.loads(path.read_text(encoding="utf-8"))
        runs = tuple(
            Run(run["specimen"], float(run["angle_deg"]), run["condition"], int(run.get("mounting", 1)))
            for run in kept["runs"]
        )
        if kept["order"] in ("file", "listed"):  # as versions up to 0.2 called it
            return RunOrder("listed", None, runs)
        if kept["order"] == "random":
            return RunOrder("random", kept["seed"], runs)
        raise ValueError(f"order {kept['order']!r}")
    except (OSError, ValueError, TypeError, KeyError, AttributeError) as error:
        do = "Move it away: the runs that are done stay done, and the others get a new order."
        raise DataError(path, wanted="an order as emg2vsa rig run writes it", found=str(error), do=do) from error
