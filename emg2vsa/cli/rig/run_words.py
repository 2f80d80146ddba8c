"""What rig run tells of runs that are over or still to do, in words or as JSON; the functions give the exit status."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

from casr.command_line import print_json
from emg2vsa.lab.pressed import Pressed
from emg2vsa.lab.sequence import DONE_BEFORE, RunsDone
from emg2vsa.rig.record.new_folder import how_ended, presses_left
from emg2vsa.rig_file import RigFile
from emg2vsa.rig_file.plans import Run
from emg2vsa.run_folders.find import left_by_emulator

if TYPE_CHECKING:
    from emg2vsa.lab.adaptive_runs import AdaptiveRuns


def one(pressed: Pressed, *, as_json: bool) -> int:
    """A run for itself; the words were said while it ended."""
    if as_json:
        print_json(pressed.document())
    return int(not pressed.completed)


def tell_left(file: RigFile, root: Path) -> None:
    """Of runs that version 0.1.0 emulated."""
    if root == file.runs and not file.leads_to_emulated and (left := left_by_emulator(file.runs)):
        print(
            f"emg2vsa: {len(left)} folders in {file.runs} were made by the emulated rig of version 0.1.0 and do not "
            f"count as done; emg2vsa clean STUDY --move-virtual moves them away.",
            file=sys.stderr,
        )


def to_do(file: RigFile, root: Path, runs: Sequence[Run], *, as_json: bool) -> int:
    """What is still to do, as options to copy."""
    presses, emulated = file.experiment.repetitions, file.leads_to_emulated
    lacking = {run: presses_left(root, run.name, presses, emulated=emulated) for run in runs}
    left = {run: count for run, count in lacking.items() if count}
    if as_json:
        listed = [run._asdict() | {"presses_left": count} for run, count in left.items()]
        print_json({"runs": len(runs), "to_do": listed})
        return 0
    for run, count in left.items():
        how = how_ended(root / run.name)
        note = f"   # {how} before, {presses - count} of {presses} presses" if how else ""
        again = f" --mounting {run.mounting}" if file.experiment.mountings > 1 else ""
        print(f"--specimen {run.specimen} --angle {run.angle_deg:g} --condition {run.condition}{again}{note}")
    do = "Name one as listed; --all leads through them; --virtual emulates them."
    again = "To repeat one, move its folder away, or choose another folder with --out."
    print(f"{len(runs)} runs, {len(left)} still to do. {do if left else again}", file=sys.stderr)
    return 0


def plates(pressed: Sequence[Pressed], root: Path, *, as_json: bool) -> int:
    """Plate indentations, and the command that evaluates them."""
    if as_json:
        print_json({"runs": [each.document() for each in pressed]})
    else:
        print(f"emg2vsa stiffness {root.with_name(f'{root.name}-plate')}/*")
    return int(not all(each.completed and each.left_safe for each in pressed))


def in_order(done: RunsDone, *, as_json: bool) -> int:
    """A sequence on the devices."""
    if as_json:
        pressed = [each.document() for _, each in done.pressed]
        print_json({"order": done.order.order, "seed": done.order.seed, "runs": pressed, "left": done.left})
    else:
        print(f"{len(done.runs) - done.left} of {len(done.runs)} runs are done; folder {done.folder}")
    return int(not done.good)


def adaptive(done: AdaptiveRuns, *, as_json: bool) -> int:
    """Presses of an unknown specimen."""
    if as_json:
        runs = [{"calibration": name} | each.document() for name, each in done.pressed]
        print_json({"belief": asdict(done.belief), "runs": runs})
        return int(not done.completed)
    print(f"kappa so far: {done.belief}")
    if not done.completed:
        print("The last run was not completed. The same command goes on from the presses that are done.")
    elif done.left:
        print("No further press is needed: the width is reached, or no press would narrow it by a tenth.")
    else:
        print("All presses that were allowed are done; --repetitions allows others.")
    return int(not done.completed)


def side_by_side(done: RunsDone, file: RigFile, *, as_json: bool) -> int:
    """Runs on the emulated rig."""
    pressed = dict(done.pressed)
    if as_json:
        ended = {run: {"ended": asdict(each.ended)} for run, each in pressed.items()}
        none = {run: {"ended": None, "note": why} for run, why in done.not_pressed.items()}
        runs = [run._asdict() | (ended | none)[run] for run in done.runs]
        print_json({"folder": str(done.folder), "runs": runs})
        return int(not done.good)
    cells = {run: "done before" if why == DONE_BEFORE else "not run" for run, why in done.not_pressed.items()}
    for run, each in done.pressed:
        cause = "" if each.completed else f", {each.ended.cause}"
        cells[run] = f"{each.ended.repetitions_done}{cause}"
    print("\n".join(_table({run: cells[run] for run in file.experiment.all_runs() if run in cells})))
    rig_min, took_min = sum(each.ended.time_s for each in pressed.values()) / 60, done.took_s / 60
    print(f"runs done: {len(pressed)}, {rig_min:.1f} min of the rig's time in {took_min:.1f} min; folder {done.folder}")
    return int(not done.good)


def _table(cells: dict[Run, str]) -> Iterator[str]:
    """Presses done, condition and angle by specimen."""
    specimens = list(dict.fromkeys(run.specimen for run in cells))
    rows = dict.fromkeys(run[1:] for run in cells)
    several = any(mounting > 1 for _, _, mounting in rows)
    yield f"{'presses done':<27}" + "".join(f"{specimen:>12}" for specimen in specimens)
    for angle_deg, condition, mounting in rows:
        title = f"{condition}, {angle_deg:g} degrees" + (f" ({mounting})" if several else "")
        own = (cells.get(Run(specimen, angle_deg, condition, mounting), "") for specimen in specimens)
        yield f"{title:<27}" + "".join(f"{cell:>12}" for cell in own)
