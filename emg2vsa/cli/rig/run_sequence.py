"""Run after run of an experiment on the real rig, in its order: put the specimen there, press Enter."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

from casr.command_line import print_json
from emg2vsa.cli.rig.ending import UNSAFE
from emg2vsa.cli.rig.hand import answer
from emg2vsa.cli.rig.kappa_options import KappaPlans
from emg2vsa.cli.rig.real_run import missing, press_run
from emg2vsa.cli.rig.same_presses import check_same_presses
from emg2vsa.rig.executor.plan_limits import check_plan
from emg2vsa.rig.plan import RIGID
from emg2vsa.rig_file import RigFile
from emg2vsa.rig_file.plans import Run, plans_of
from emg2vsa.rig_file.sequence import RunOrder

_ROUNDS = 3
"""So often presses that were rejected are repeated before the sequence ends."""


def run_sequence(
    file: RigFile,
    runs: Sequence[Run],
    root: Path,
    order: RunOrder,
    *,
    kappa: KappaPlans,
    yes: bool,
    as_json: bool,
) -> int:
    """All presses that ``runs`` still lack, in ``order``; exit status.

    A run whose presses were rejected is repeated; one that ends otherwise ends the sequence, which the same command
    takes up again. So does one that leaves the probe on the specimen, or the motors on, however whole its presses are.
    The status is 0 only where every run was completed.
    """
    todo = [run for run in order.runs if run in runs]
    plans = dict(zip(todo, plans_of(file, todo), strict=True))
    for run, plan in plans.items():
        check_plan(plan, file.rig)
        check_same_presses(root, run.name, plan, file.rig, emulated=file.leads_to_emulated)
    judged = kappa(plans)
    done: list[dict[str, Any]] = []
    status = 0
    for number, run in enumerate(todo, start=1):
        if not missing(file, run, root):
            continue
        if not yes and (said := _placed(number, len(todo), run, missing(file, run, root))) != "":
            if said == "q":
                status = 1
                break
            continue
        left_safe = True
        for _ in range(_ROUNDS):
            if not (presses := missing(file, run, root)):
                break
            plan = replace(plans[run], repetitions=presses, order=order.place(run))
            folder, ended = press_run(file, run, plan, root, kappa=judged[run], quiet=as_json)
            done.append({"folder": str(folder), "ended": asdict(ended)})
            status = status or int(ended.how != "completed")
            left_safe = ended.retracted and ended.deactivated
            if ended.how not in ("completed", "rejected") or not left_safe:
                break
        if not left_safe:
            print(UNSAFE.format(folder=folder, rig=file.path), file=sys.stderr)
            status = 1
            break
        if missing(file, run, root):
            print("The sequence ends here; the same command takes it up again.", file=sys.stderr)
            status = 1
            break
    left = sum(bool(missing(file, run, root)) for run in todo)
    if as_json:
        print_json({"order": order.order, "seed": order.seed, "runs": done, "left": left})
    else:
        print(f"{len(todo) - left} of {len(todo)} runs are done; folder {root}")
    return status


def _placed(number: int, count: int, run: Run, presses: int) -> str:
    """Empty when the specimen lies there; s to leave the run out, q to stop."""
    under = "the rigid motor" if run.condition == RIGID else f"the qbmove ({run.condition})"
    anew = f", mounted anew ({run.mounting})" if run.mounting > 1 else ""
    question = (
        f"{number}/{count}: put {run.specimen} at {run.angle_deg:g} degrees under {under}{anew}, {presses} presses. "
        "Enter: press it; s: leave it out; q: stop. "
    )
    while (said := answer(question).lower()) not in ("", "s", "q"):
        pass
    return said
