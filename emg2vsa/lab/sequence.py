"""The runs of an experiment in their order, and plates: on the devices one by one, else on the emulated rig."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from emg2vsa.errors import SettingError
from emg2vsa.lab.judging import WHOLE_PRESSES, Judging, say_kappa, say_reachable
from emg2vsa.lab.person import NOBODY, Person
from emg2vsa.lab.pressed import Pressed, summary
from emg2vsa.lab.pressing import Pressing, VirtualJob, carried_out, pressing_of, virtual_job
from emg2vsa.rig.executor.guards import laxer_guards
from emg2vsa.rig.executor.plan_limits import check_plan
from emg2vsa.rig.experiment import plate_plan
from emg2vsa.rig.plan import RIGID, RunPlan
from emg2vsa.rig_file import RigFile
from emg2vsa.rig_file.plans import Order, Run, RunOrder, ordered, run_order
from emg2vsa.study import plates_beside
from emg2vsa.study_file.problems import nearest

DONE_BEFORE = "done before"
_ROUNDS = 3
"""So often presses that were rejected are repeated before the sequence ends."""


@dataclass(frozen=True)
class RunsDone:
    """What became of runs that were asked for.

    folder : of the runs. order : in which they are done. runs : those asked for, in this order.
    pressed : what was pressed now, several where rejected presses were repeated. not_pressed : run to the reason.
    left : runs that still lack presses. good : every press was whole, and the sequence went on to its end.
    took_s : time that it took, s.
    """

    folder: Path
    order: RunOrder
    runs: tuple[Run, ...]
    pressed: tuple[tuple[Run, Pressed], ...]
    not_pressed: Mapping[Run, str]
    left: int
    good: bool
    took_s: float


def sequence(
    file: RigFile, runs: Sequence[Run] = (), *, order: Order | None = None, seed: int | None = None, kept: bool = True,
    presses: int | None = None, folder: str | Path | None = None, virtual: bool = False, jobs: int = 1,
    judging: Judging = WHOLE_PRESSES, person: Person = NOBODY,
) -> RunsDone:  # fmt: skip
    """All presses that the experiment still lacks, or only ``runs`` of it; a sequence that was stopped goes on.

    On the devices ``person`` is asked to place each specimen. A run whose presses were rejected is repeated there; one
    that ends otherwise ends the sequence, and so does one that leaves the probe on the specimen, or the motors on.
    A virtual sequence uses ``jobs`` processes, and tells what fails in one run in ``not_pressed``. With more than one,
    a script needs the line ``if __name__ == "__main__":``, as for `multiprocessing`.

    order, seed : None: those kept in the folder of the runs, else those of the rig file. kept : in order.json.
    presses : of each run of a virtual sequence, instead of the experiment's. Else as `press`.

    >>> done = rig.sequence(file, virtual=True)
    >>> [(run.name, one.ended.how) for run, one in done.pressed]
    """
    pressing = pressing_of(file, folder, virtual, person, presses=presses, jobs=jobs)
    if unknown := [run for run in runs if run not in file.experiment.all_runs()]:
        do = "Choose among file.experiment.all_runs()."
        raise SettingError("runs", wanted="runs of the rig file", found=str(unknown[0]), do=do)
    if presses is not None and not virtual:
        do = "Leave it out: the rig makes the presses that [experiment] repetitions asks for."
        raise SettingError("presses", wanted="a virtual sequence beside it", found="the devices of the rig file", do=do)
    drawn = run_order(pressing.root, file.experiment, order, seed) if kept else ordered(file.experiment, order, seed)
    todo = tuple(run for run in drawn.runs if not runs or run in runs)
    if virtual:
        return _side_by_side(pressing, todo, drawn, judging, presses, jobs)
    return _in_order(pressing, todo, drawn, judging)


def plates(
    file: RigFile, specimens: Sequence[str], *, folder: str | Path | None = None, virtual: bool = False,
    person: Person = NOBODY,
) -> tuple[Pressed, ...]:  # fmt: skip
    """The trials that each specimen still lacks, in ``<folder>/<specimen>``, or beside the runs; what was pressed now.

    The last one was not left safe where the probe stayed on the specimen, or the motors on: it ends the others.
    SettingError : a specimen that the experiment has not, or a plan that breaks a limit. Else as `press`.
    """
    pressing, trials = pressing_of(file, folder, virtual, person), file.plate.trials
    known = tuple(
        dict.fromkeys(
            (*file.experiment.specimens, *(file.emulated.stiffness_n_per_mm if virtual and file.emulated else ()))
        )
    )
    plans = {name: pressing.witnessed(plate_plan(file.plate, file.experiment, name)) for name in specimens}
    for name, plan in plans.items():
        if name not in known:
            do = nearest(name, known, "Add it to [experiment], or choose another.")
            raise SettingError(f"{file.path}, --plate", wanted=", ".join(known), found=name, do=do)
        check_plan(plan, file.rig)
    bare = replace(file, devices=replace(file.devices, camera=None))
    own = replace(pressing, file=bare, root=pressing.root if folder else plates_beside(pressing.root))
    pressed: list[Pressed] = []
    for name, plan in plans.items():
        own.check_same(name, plan)
        if not (left := own.missing(name, trials)):
            person.warn(f"{name}: done before")
            continue
        if not virtual:
            person.answer(
                f"Put the flat plate on the rigid motor and {name} under it, {left} trials. Enter: press it. "
            )
        pressed.append(one := own.press(replace(plan, repetitions=left), own.folder(name, trials)))
        person.warn(f"{name}: {summary(one.ended, left)}")
        own.warn_unless_safe(one)
        if not one.left_safe:
            break
    return tuple(pressed)


def _in_order(pressing: Pressing, todo: tuple[Run, ...], order: RunOrder, judging: Judging) -> RunsDone:
    start, person = time.monotonic(), pressing.person
    plans = _plans(pressing, todo)
    judged = judging.plans(pressing.file, plans, emulated=pressing.emulated)
    pressed: list[tuple[Run, Pressed]] = []
    good = True
    for number, run in enumerate(todo, start=1):
        if not (presses := pressing.missing(run.name)):
            continue
        if said := _placed(pressing, f"{number}/{len(todo)}", run, presses):
            if said == "q":
                good = False
                break
            continue
        safe = True
        for _ in range(_ROUNDS):
            if not (presses := pressing.missing(run.name)):
                break
            plan = replace(plans[run], repetitions=presses, order=order.place(run))
            one = pressing.press(plan, pressing.folder(run.name), judged[run])
            pressed.append((run, one))
            good, safe = good and one.completed, one.left_safe
            if one.ended.how not in ("completed", "rejected") or not safe:
                break
        if not safe:
            pressing.warn_unless_safe(one)
        elif pressing.missing(run.name):
            person.warn("The sequence ends here; the same command takes it up again.")
        else:
            continue
        good = False
        break
    left = sum(bool(pressing.missing(run.name)) for run in todo)
    return RunsDone(pressing.root, order, todo, tuple(pressed), {}, left, good, time.monotonic() - start)


def _side_by_side(
    pressing: Pressing, todo: tuple[Run, ...], order: RunOrder, judging: Judging, presses: int | None, jobs: int
) -> RunsDone:
    start, person, file = time.monotonic(), pressing.person, pressing.file
    plans = _plans(pressing, todo, presses)
    judged = judging.plans(file, plans, emulated=True)
    for line in laxer_guards(file.rig):
        person.say(f"guard: {line}")
    waiting: dict[Run, VirtualJob] = {}
    not_pressed: dict[Run, str] = {}
    for run, plan in plans.items():
        if lacking := pressing.missing(run.name, plan.repetitions):
            own = replace(plan, repetitions=lacking, order=order.place(run) if len(todo) > 1 else None)
            waiting[run] = virtual_job(file, own, pressing.folder(run.name, plan.repetitions), judged[run])
            if (kappa := judged[run]) is not None:
                say_reachable(kappa, own, person, emulated=True)
        else:
            not_pressed[run] = DONE_BEFORE
    found: dict[Run, Pressed] = {}
    for run, result in carried_out(waiting, jobs):
        if isinstance(result, str):
            not_pressed[run] = line = result
        else:
            found[run] = Pressed(waiting[run].folder, result)
            line = summary(result, waiting[run].plan.repetitions)
        person.note(f"{len(found) + len(not_pressed)}/{len(todo)} {run.name}: {line}")
        if run in found and found[run].ended.how == "interrupted":
            raise KeyboardInterrupt
    for job in waiting.values():
        if job.kappa is not None:
            say_kappa(job.folder, person)
    good = len(found) == len(waiting) and all(each.completed for each in found.values())
    pressed = tuple((run, found[run]) for run in todo if run in found)
    left = sum(bool(pressing.missing(run.name, presses)) for run in todo)
    return RunsDone(pressing.root, order, todo, pressed, not_pressed, left, good, time.monotonic() - start)


def _plans(pressing: Pressing, runs: Sequence[Run], presses: int | None = None) -> dict[Run, RunPlan]:
    plans = pressing.plans(runs, presses)
    for run, plan in plans.items():
        pressing.check_same(run.name, plan)
    return plans


def _placed(pressing: Pressing, number: str, run: Run, presses: int) -> str:
    """Empty when the specimen lies there; s to leave the run out, q to stop."""
    under = "the rigid motor" if run.condition == RIGID else f"the qbmove ({run.condition})"
    anew = f", mounted anew ({run.mounting})" if run.mounting > 1 else ""
    question = (
        f"{number}: put {run.specimen} at {run.angle_deg:g} degrees under {under}{anew}, {presses} presses. "
        "Enter: press it; s: leave it out; q: stop. "
    )
    return pressing.person.answer(question, ("", "s", "q"))
