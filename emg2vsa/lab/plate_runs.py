"""Indentation of specimens by a flat plate, on the real rig or the emulated one, for ``emg2vsa tools stiffness``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from emg2vsa.errors import SettingError
from emg2vsa.lab.ending import summary
from emg2vsa.lab.person import NOBODY, Person
from emg2vsa.lab.pressed import Pressed
from emg2vsa.lab.pressing import pressing_of
from emg2vsa.rig.executor.plan_limits import check_plan
from emg2vsa.rig.experiment import plate_plan
from emg2vsa.rig_file import RigFile
from emg2vsa.study_file.problems import nearest


def plates(
    file: RigFile, specimens: Sequence[str], *, folder: str | Path | None = None, virtual: bool = False,
    person: Person = NOBODY,
) -> tuple[Pressed, ...]:  # fmt: skip
    """The trials that each specimen still lacks, in ``<folder>-plate/<specimen>``; what was pressed now.

    The last one was not left safe where the probe stayed on the specimen, or the motors on: it ends the others.
    SettingError : a specimen that the experiment has not, or a plan that breaks a limit. Else as `press`.
    """
    pressing, trials = pressing_of(file, folder, virtual, person), file.plate.trials
    known = file.experiment.specimens
    plans = {name: plate_plan(file.plate, file.experiment, name) for name in specimens}
    for name, plan in plans.items():
        if name not in known:
            do = nearest(name, known, "Add it to [experiment], or choose another.")
            raise SettingError(f"{file.path}, --plate", wanted=", ".join(known), found=name, do=do)
        check_plan(plan, file.rig)
    bare = replace(file, devices=replace(file.devices, camera=None))
    own = replace(pressing, file=bare, root=pressing.root.with_name(f"{pressing.root.name}-plate"))
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
