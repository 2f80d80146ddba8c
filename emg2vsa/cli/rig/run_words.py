"""What rig run tells of runs that are over or still to do, in words or as JSON; the functions give the exit status."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Sequence
from dataclasses import asdict, astuple
from itertools import takewhile
from pathlib import Path
from typing import TYPE_CHECKING, Any

from emg2vsa.cli.rig.choice import finish
from emg2vsa.lab.pressed import Pressed
from emg2vsa.lab.sequence import DONE_BEFORE, RunsDone
from emg2vsa.rig.record.new_folder import folders_of, how_ended, presses_left
from emg2vsa.rig_file import RigFile
from emg2vsa.rig_file.plans import Run
from emg2vsa.run_folders.find import left_by_emulator
from emg2vsa.run_folders.weighed import weighed_presses
from emg2vsa.run_scores.product import WeighedPress

if TYPE_CHECKING:
    from emg2vsa.lab.adaptive_runs import AdaptiveRuns

_MOST_PRESSES = 30  # of more, those that are ok are counted


def tell_left(file: RigFile, root: Path) -> None:
    """Tell the user of runs that version 0.1.0 emulated."""
    if root == file.runs and not file.leads_to_emulated and (left := left_by_emulator(file.runs)):
        print(
            f"emg2vsa: {len(left)} folders in {file.runs} were made by the emulated rig of version 0.1.0 and do not "
            f"count as done; emg2vsa tools clean STUDY --move-virtual moves them away.",
            file=sys.stderr,
        )


def to_do(arguments: argparse.Namespace, file: RigFile, root: Path, runs: Sequence[Run]) -> int:
    """What is still to do, as options to copy."""
    presses, emulated = file.experiment.repetitions, file.leads_to_emulated
    lacking = {run: presses_left(root, run.name, presses, emulated=emulated) for run in runs}
    left = {run: count for run, count in lacking.items() if count}
    lines = []
    for run, count in left.items():
        how = how_ended(root / run.name)
        note = f"   # {how} before, {presses - count} of {presses} presses" if how else ""
        again = f" --mounting {run.mounting}" if file.experiment.mountings > 1 else ""
        lines.append(f"--specimen {run.specimen} --angle {run.angle_deg:g} --condition {run.condition}{again}{note}")
    listed = [run._asdict() | {"presses_left": count} for run, count in left.items()]
    finish(arguments, {"runs": len(runs), "to_do": listed}, *lines)
    if not arguments.json:
        do = "Name one as listed; --all leads through them; --virtual emulates them."
        again = "To repeat one, move its folder away, or choose another folder with --out."
        print(f"{len(runs)} runs, {len(left)} still to do. {do if left else again}", file=sys.stderr)
    return 0


def plates(arguments: argparse.Namespace, pressed: Sequence[Pressed], root: Path) -> int:
    """Plate indentations, and the command that evaluates them."""
    command = f"emg2vsa tools stiffness {root}/*"
    good = all(each.completed and each.left_safe for each in pressed)
    return finish(arguments, {"runs": [each.document() for each in pressed]}, command, good=good)


def in_order(arguments: argparse.Namespace, done: RunsDone) -> int:
    """A sequence on the devices."""
    pressed = [each.document() for _, each in done.pressed]
    weighed = _weighed(done)
    result = {"order": done.order.order, "seed": done.order.seed, "runs": pressed, "left": done.left}
    result["presses"] = list(map(asdict, weighed))
    whole = f"{len(done.runs) - done.left} of {len(done.runs)} runs are done; folder {done.folder}"
    return finish(arguments, result, *_specimens(weighed), whole, good=done.good)


def adaptive(arguments: argparse.Namespace, done: AdaptiveRuns) -> int:
    """Presses of an unknown specimen."""
    why = "All presses that were allowed are done; --repetitions allows others."
    if done.left:
        why = "No further press is needed: the width is reached, or no press would narrow it by a tenth."
    if not done.completed:
        why = "The last run was not completed. The same command goes on from the presses that are done."
    runs = [{"calibration": name} | each.document() for name, each in done.pressed]
    result = {"belief": asdict(done.belief), "runs": runs}
    return finish(arguments, result, f"kappa so far: {done.belief}", why, good=done.completed)


def side_by_side(arguments: argparse.Namespace, done: RunsDone, file: RigFile) -> int:
    """Runs on the emulated rig."""
    ended: dict[Run, dict[str, Any]] = {run: {"ended": asdict(each.ended)} for run, each in done.pressed}
    ended |= {run: {"ended": None, "note": why} for run, why in done.not_pressed.items()}
    weighed = _weighed(done)
    result = {"folder": str(done.folder), "runs": [run._asdict() | ended[run] for run in done.runs]}
    result["presses"] = list(map(asdict, weighed))
    cells = {run: why if why == DONE_BEFORE else "not run" for run, why in done.not_pressed.items()}
    for run, each in done.pressed:
        cells[run] = f"{each.ended.repetitions_done}" + ("" if each.completed else f", {each.ended.cause}")
    rig_min, took_min = sum(each.ended.time_s for _, each in done.pressed) / 60, done.took_s / 60
    times = f"{rig_min:.1f} min of the rig's time in {took_min:.1f} min"
    whole = f"runs done: {len(done.pressed)}, {times}; folder {done.folder}"
    table = _table({run: cells[run] for run in file.experiment.all_runs() if run in cells})
    return finish(arguments, result, *table, *_specimens(weighed), whole, good=done.good)


def _weighed(done: RunsDone) -> list[WeighedPress]:
    """All presses of the runs that were asked for, those of former days too."""
    return [*weighed_presses(f for run in done.runs for f in takewhile(Path.exists, folders_of(done.folder, run.name)))]


def _specimens(presses: Sequence[WeighedPress]) -> Iterator[str]:
    """Which specimen each press tells; of many presses those that are not ok."""
    shown = [each for each in presses if len(presses) <= _MOST_PRESSES or each.verdict != "ok"]
    width = 2 + max((len(each.folder) for each in shown), default=0)
    if shown:
        yield f"{'run':<{width}}{'press':>5}  {'specimen':<10}{'stated':>8}  {'kappa, N/mm (95 %)':<24}verdict"
    for each in shown:
        stated, kappa, *interval = ("" if value != value else f"{value:.3g}" for value in astuple(each)[3:7])
        kappa += f" ({' to '.join(interval)})" if kappa else ""
        where = f"{each.folder:<{width}}{each.press:>5}  {each.specimen:<10}"
        yield f"{where}{stated:>8}  {kappa:<24}{each.verdict}: {each.said}"
    if len(shown) < len(presses):
        yield f"specimens: {len(presses) - len(shown)} of {len(presses)} presses are ok"


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
