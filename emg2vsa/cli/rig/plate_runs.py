"""Indentation of specimens by a flat plate, on the real rig or the emulated one, for ``emg2vsa stiffness``."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import asdict, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from casr.command_line import print_json
from emg2vsa.cli.rig.ending import UNSAFE, summary
from emg2vsa.cli.rig.hand import answer
from emg2vsa.cli.rig.real_run import press_plan
from emg2vsa.cli.rig.same_presses import check_same_presses
from emg2vsa.errors import SettingError
from emg2vsa.rig.emulated.virtual_run import run_virtual
from emg2vsa.rig.executor.plan_limits import check_plan
from emg2vsa.rig.experiment import plate_plan
from emg2vsa.rig.record.ended import Ended
from emg2vsa.rig.record.new_folder import new_folder, presses_left
from emg2vsa.rig_file import RigFile
from emg2vsa.study_file.problems import nearest


def run_plates(file: RigFile, specimens: Sequence[str], root: Path, *, virtual: bool, yes: bool, as_json: bool) -> int:
    """The trials that each specimen still lacks, in ``<root>-plate/<specimen>``; exit status.

    SettingError : a specimen that the experiment has not, or a plan that breaks a limit.
    """
    known = file.experiment.specimens
    for name in specimens:
        if name not in known:
            do = nearest(name, known, "Add it to [experiment], or choose another.")
            raise SettingError(f"{file.path}, --plate", wanted=", ".join(known), found=name, do=do)
        check_plan(plate_plan(file.plate, file.experiment, name), file.rig)
    root = root.with_name(f"{root.name}-plate")
    emulated = virtual or file.leads_to_emulated
    told: list[dict[str, Any]] = []
    status = 0
    for name in dict.fromkeys(specimens):
        plan = plate_plan(file.plate, file.experiment, name)
        check_same_presses(root, name, plan, file.rig, emulated=emulated)
        left = presses_left(root, name, file.plate.trials, emulated=emulated)
        if not left:
            print(f"{name}: done before", file=sys.stderr)
            continue
        if not virtual and not yes:
            answer(f"Put the flat plate on the rigid motor and {name} under it, {left} trials. Enter: press it. ")
        folder, ended = _pressed(file, name, left, root, virtual=virtual, quiet=as_json)
        print(f"{name}: {summary(ended, left)}", file=sys.stderr)
        told.append({"folder": str(folder), "ended": asdict(ended)})
        status = status or int(ended.how != "completed")
        if not (ended.retracted and ended.deactivated):
            print(UNSAFE.format(folder=folder, rig=file.path), file=sys.stderr)
            status = 1
            break
    if as_json:
        print_json({"runs": told})
    else:
        print(f"emg2vsa stiffness {root}/*")
    return status


def _pressed(file: RigFile, name: str, trials: int, root: Path, *, virtual: bool, quiet: bool) -> tuple[Path, Ended]:
    plan = replace(plate_plan(file.plate, file.experiment, name), repetitions=trials)
    if not virtual:
        bare = replace(file, devices=replace(file.devices, camera=None))
        folder = new_folder(root, name, file.plate.trials, emulated=file.leads_to_emulated)
        return folder, press_plan(bare, plan, folder, quiet=quiet)
    if file.emulated is None:
        do = "Add it (docs/reference/rig-file.md), or leave out --virtual."
        raise SettingError(file.path, wanted="a table [emulated]", found="none", do=do)
    folder = new_folder(root, name, file.plate.trials, emulated=True)
    started = datetime.now(UTC)
    return folder, run_virtual(plan, file.rig, file.emulated, folder, started=started, run=f"{folder.name}, plate")
