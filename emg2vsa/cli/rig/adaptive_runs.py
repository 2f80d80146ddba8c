"""Run after run of one unknown specimen, each chosen by what the presses before it told of its stiffness."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from itertools import takewhile
from pathlib import Path
from typing import Any

from casr.command_line import print_json
from emg2vsa.calibration.next_press import Choice, Done, belief, next_press
from emg2vsa.calibration.online import OnlineCalibration
from emg2vsa.calibration_file import open_calibration
from emg2vsa.cli.rig.ending import UNSAFE, summary
from emg2vsa.cli.rig.kappa_options import kappa_plans
from emg2vsa.cli.rig.next import check_judged_by, last_estimates, with_run
from emg2vsa.cli.rig.real_run import press_plan
from emg2vsa.cli.rig.same_presses import check_same_presses
from emg2vsa.cli.rig.virtual_runs import press_virtually
from emg2vsa.errors import SettingError
from emg2vsa.rig.executor.plan_limits import check_plan
from emg2vsa.rig.kappa.live_kappa import KAPPA_FILE, KappaPlan
from emg2vsa.rig.plan import RIGID
from emg2vsa.rig.record.new_folder import folders_of
from emg2vsa.rig_file import RigFile
from emg2vsa.rig_file.plans import Run, chosen_runs, plans_of


@dataclass
class Bench:
    """Where the specimen lies. place : angle and kind of actuator, None before the first run. mountings : index of a
    calibration to the mounting that it has pressed there."""

    place: tuple[float, bool] | None = None
    mountings: dict[int, int] = field(default_factory=dict)


def run_adaptively(arguments: argparse.Namespace, file: RigFile, root: Path) -> int:
    """Press the specimen as ``next_press`` says, until no further press is worthwhile; exit status.

    Judged presses of the specimen in ``root`` count along. SettingError, DataError : an option, a calibration or a run
    that does not fit, or nobody there who mounts the specimen.
    """
    runs = _runs(arguments, file)
    plans = dict(zip(runs, plans_of(file, runs), strict=True))
    for plan in plans.values():
        check_plan(plan, file.rig)
    judged = _judged(kappa_plans(arguments, file, plans))
    calibrations = [judged[run].calibration for run in runs]
    done = {index: _done_before(root, run, judged[run]) for index, run in enumerate(runs)}
    left = arguments.repetitions or file.experiment.repetitions * len(runs)
    bench, made, status = Bench(), list[dict[str, Any]](), 0
    while left and (choice := next_press(calibrations, done, arguments.stop_at or 0.0)):
        run, presses = runs[choice.calibration], min(choice.presses, left)
        if not arguments.json:
            _say(calibrations, done, choice, judged[run].name, presses)
        mounting, new = mounted(bench, choice, runs, root, virtual=arguments.virtual)
        here = run._replace(mounting=mounting)
        plan = replace(plans[run], repetitions=presses, mounting=mounting)
        check_same_presses(root, here.name, plan, file.rig, emulated=arguments.virtual or file.leads_to_emulated)
        folder = next(each for each in folders_of(root, here.name) if not each.exists())
        if arguments.virtual:
            ended = press_virtually(file, plan, folder, judged[run])
            print(f"{folder.name}: {summary(ended, presses)}", file=sys.stderr, flush=True)
        else:
            ended = press_plan(file, plan, folder, kappa=judged[run], quiet=arguments.json)
        made.append({"calibration": judged[run].name, "folder": str(folder), "ended": asdict(ended)})
        if not (ended.retracted and ended.deactivated):
            print(UNSAFE.format(folder=folder, rig=file.path), file=sys.stderr)
        if ended.how != "completed" or not (ended.retracted and ended.deactivated):
            status = 1
            break
        told = last_estimates(folder / KAPPA_FILE)
        done[choice.calibration] = with_run(done[choice.calibration], told, presses, new_mounting=new)
        left -= presses
    _report(arguments, calibrations, done, made, stopped=bool(status), left=left)
    return status


def _runs(arguments: argparse.Namespace, file: RigFile) -> tuple[Run, ...]:
    """The run of the one specimen that belongs to each calibration."""
    for option, given, do in (
        ("--angle", arguments.angle, "Leave it out: the calibrations say which angles there are."),
        ("--condition", arguments.condition, "Leave it out: the calibrations say which conditions there are."),
        ("--mounting", arguments.mounting, "Leave it out: every new mounting gets the next number."),
    ):
        if given:
            raise SettingError(option, wanted="no choice of runs beside --adaptive", found=f"{given[0]}", do=do)
    if len(arguments.specimen) != 1:
        found = ", ".join(arguments.specimen) or "none"
        raise SettingError("--specimen", wanted="one specimen", found=found, do="Name the unknown specimen.")
    if not arguments.calibration:
        do = "Add --calibration FILE for every angle and condition that may be pressed."
        raise SettingError("--adaptive", wanted="--calibration beside this option", found="none", do=do)
    opened = [open_calibration(path) for path in arguments.calibration]
    return tuple(
        chosen_runs(file, arguments.specimen, [own.angle_deg], [own.condition], [1])[0]
        for own in opened
    )  # fmt: skip


def _judged(plans: Mapping[Run, KappaPlan | None]) -> dict[Run, KappaPlan]:
    return {run: plan for run, plan in plans.items() if plan is not None}


def _done_before(root: Path, run: Run, judged: KappaPlan) -> Done:
    """Presses of this specimen, angle and condition in ``root``. DataError where another calibration judged them."""
    done = Done()
    for mounting in range(1, _next_mounting(root, run)):
        new = True
        for folder in _there(root, run._replace(mounting=mounting)):
            if told := last_estimates(folder / KAPPA_FILE):
                check_judged_by(folder, judged.calibration, judged.name)
                done, new = with_run(done, told, len(told), new_mounting=new), False
    return done


def _there(root: Path, run: Run) -> list[Path]:
    return list(takewhile(Path.exists, folders_of(root, run.name)))


def _next_mounting(root: Path, run: Run) -> int:
    mounting = 1
    while _there(root, run._replace(mounting=mounting)):
        mounting += 1
    return mounting


def mounted(bench: Bench, choice: Choice, runs: tuple[Run, ...], root: Path, *, virtual: bool) -> tuple[int, bool]:
    """Number of the mounting, and whether it is a new one; the operator is asked where a hand is needed.

    An emulated rig in virtual time mounts by itself. Conditions of the qbmove at one angle need no hand. Nor does the
    first run where all calibrations are of one place: the specimen lies there as for any other run.
    """
    run, places = runs[choice.calibration], {_place(run) for run in runs}
    again = choice.remount and choice.calibration in bench.mountings
    moved = bench.place != _place(run) and (bench.place is not None or len(places) > 1)
    if again or moved:
        if not virtual:
            _ask(run, anew=again)
        bench.mountings.clear()
    bench.place = _place(run)
    if number := bench.mountings.get(choice.calibration):
        return number, False
    number = bench.mountings[choice.calibration] = _next_mounting(root, run)
    return number, True


def _place(run: Run) -> tuple[float, bool]:
    return run.angle_deg, run.condition == RIGID


def _ask(run: Run, *, anew: bool) -> None:
    under = "the rigid motor" if run.condition == RIGID else "the qbmove"
    todo = f"{'mount anew' if anew else 'put'} {run.specimen} at {run.angle_deg:g} degrees under {under}"
    print(f"{todo[0].upper()}{todo[1:]}, then press Enter. ", end="", file=sys.stderr, flush=True)
    try:
        input()
    except EOFError:
        print(file=sys.stderr)
        raise SettingError(
            "--adaptive", wanted=f"somebody to {todo}", found="the end of the standard input",
            do="Run it in a terminal; the same command goes on from the presses that are done.",
        ) from None  # fmt: skip


def _say(
    calibrations: list[OnlineCalibration], done: Mapping[int, Done], choice: Choice, name: str, presses: int
) -> None:
    _say_belief(calibrations, done)
    mounting = ", a new mounting" if choice.remount else ""
    print(
        f"next: presses: {presses}, by {name}{mounting}; {choice.presses} are expected to leave "
        f"±{choice.half_width:.0%} of kappa",
        flush=True,
    )


def _say_belief(calibrations: list[OnlineCalibration], done: Mapping[int, Done]) -> None:
    believed = belief(calibrations, done)
    low, high = believed.interval(calibrations[0].settings.confidence)
    print(f"kappa so far: {believed.middle:.3g} N/mm, from {low:.3g} to {high:.3g}")


def _report(
    arguments: argparse.Namespace, calibrations: list[OnlineCalibration], done: Mapping[int, Done],
    made: list[dict[str, Any]], *, stopped: bool, left: int,
) -> None:  # fmt: skip
    if arguments.json:
        believed = belief(calibrations, done)
        low, high = believed.interval(calibrations[0].settings.confidence)
        told = {"kappa_n_per_mm": believed.middle, "low_n_per_mm": low, "high_n_per_mm": high}
        print_json({"belief": told, "runs": made})
        return
    _say_belief(calibrations, done)
    if stopped:
        print("The last run was not completed. The same command goes on from the presses that are done.")
    elif left:
        print("No further press is needed: the width is reached, or no press would narrow it by a tenth.")
    else:
        print("All presses that were allowed are done; --repetitions allows others.")
