"""What presses of an unknown specimen have told, which press would tell most, and run after run so chosen."""

from __future__ import annotations

import csv
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import takewhile
from pathlib import Path
from typing import Any

from emg2vsa.calibration.next_press import COUNTS, Choice, Done, belief, next_press, options
from emg2vsa.calibration.online import OnlineCalibration
from emg2vsa.calibration_file import open_calibration, sha256_of
from emg2vsa.errors import DataError, SettingError
from emg2vsa.lab.judging import Judging
from emg2vsa.lab.person import NOBODY, Person
from emg2vsa.lab.pressed import Pressed, summary
from emg2vsa.lab.pressing import pressing_of
from emg2vsa.rig.kappa.live_kappa import KAPPA_FILE, KappaPlan
from emg2vsa.rig.plan import RIGID
from emg2vsa.rig.record.new_folder import KAPPA_ABOUT_FILE, PLAN_FILE, folders_of
from emg2vsa.rig_file import RigFile
from emg2vsa.rig_file.plans import Run, chosen_runs


@dataclass(frozen=True)
class Believed:
    """Belief in kappa, N/mm: its median, and the interval that it lies in by the confidence of the calibrations."""

    kappa_n_per_mm: float
    low_n_per_mm: float
    high_n_per_mm: float

    def __str__(self) -> str:
        return f"{self.kappa_n_per_mm:.3g} N/mm, from {self.low_n_per_mm:.3g} to {self.high_n_per_mm:.3g}"


@dataclass(frozen=True)
class NextPresses:
    """What to press next. options : the most informative first. chosen : None where no further press is worthwhile.

    The ``calibration`` of a choice is its index in ``calibrations``, which are names of files.
    """

    calibrations: tuple[str, ...]
    belief: Believed
    options: tuple[Choice, ...]
    chosen: Choice | None


def next_presses(
    calibrations: Sequence[str | Path],
    done: Sequence[str | Path] = (),
    presses: Sequence[int] = (),
    stop_at: float = 0.0,
) -> NextPresses:
    """Calibrations (stiffness preset and angle), numbers of presses and new mountings, by what they promise to tell.

    calibrations : files of emg2vsa run. done : folders of runs whose presses were judged; one folder is one mounting.
    presses : numbers to weigh; none: 1, 2, 3, 5 and 10. stop_at : half width of the interval, as a share of kappa, at
    which no further press is needed.

    DataError : a file that cannot be used; a run that fits no calibration, was not judged, or would count twice.
    """
    paths = [Path(path) for path in calibrations]
    opened = [open_calibration(path) for path in paths]
    before = _done([Path(folder) for folder in done], opened, paths)
    listed = options(opened, before, tuple(sorted(set(presses))) or COUNTS)
    chosen = next_press(opened, before, stop_at)
    return NextPresses(tuple(path.name for path in paths), believed(opened, before), listed, chosen)


def believed(calibrations: Sequence[OnlineCalibration], done: Mapping[int, Done]) -> Believed:
    """Belief in kappa from what the calibrations (by index) have said so far."""
    found = belief(calibrations, done)
    return Believed(found.middle, *found.interval(calibrations[0].settings.confidence))


def _done(folders: Sequence[Path], calibrations: Sequence[OnlineCalibration], paths: Sequence[Path]) -> dict[int, Done]:
    """Presses so far, by calibration. DataError where a run fits none, was not judged, or would count twice."""
    places = [(each.angle_deg, each.condition) for each in calibrations]
    for i, (angle_deg, condition) in enumerate(places):
        if (angle_deg, condition) in places[:i]:
            found_there = f"{paths[places.index(places[i])]} too is of {angle_deg:g}°, {condition}"
            do = "Give one of the two."
            raise DataError(paths[i], wanted="one calibration for each angle and condition", found=found_there, do=do)
    found: dict[int, Done] = {}
    pressed: dict[str, Path] = {}
    seen: set[Path] = set()
    for folder in folders:
        if folder.resolve() in seen:
            raise DataError(folder, wanted="every run once", found="it twice", do="Name it once with --done.")
        seen.add(folder.resolve())
        plan, rows = _plan(folder / PLAN_FILE), last_estimates(folder / KAPPA_FILE)
        place = plan["angle_deg"], plan["condition"]
        if place not in places:
            there = ", ".join(path.name for path in paths)
            do = "Give the calibration of this angle and condition too."
            raise DataError(
                folder, wanted=f"one of the calibrations {there}", found=f"{place[0]:g}°, {place[1]}", do=do
            )
        pressed.setdefault(plan["specimen"], folder)
        if len(pressed) > 1:
            (one, first), (other, _) = pressed.items()
            do = "Name runs of one specimen only."
            raise DataError(folder, wanted=f"a run of {one}, as {first.name} is", found=f"one of {other}", do=do)
        if not rows:
            do = "Press with rig run --calibration."
            raise DataError(folder / KAPPA_FILE, wanted="presses that were judged", found="none", do=do)
        index = places.index(place)
        check_judged_by(folder, calibrations[index], paths[index].name)
        found[index] = with_run(found.get(index, Done()), rows, len(rows), new_mounting=True)
    return found


def check_judged_by(folder: Path, calibration: OnlineCalibration, name: str) -> None:
    """DataError where kappa.json names another calibration than the file ``name``; earlier versions do not tell."""
    about = folder / KAPPA_ABOUT_FILE
    try:
        told = json.loads(about.read_text(encoding="utf-8")).get("sha256")
    except FileNotFoundError:
        return
    except (OSError, ValueError, AttributeError) as error:
        do = "Name the folder of a run that rig run made."
        raise DataError(about, wanted="by which calibration presses were judged", found=_why(error), do=do) from error
    if told is not None and told != (own := sha256_of(calibration)):
        do = "Give the calibration that the run was judged by, or press again."
        raise DataError(f"{about}, sha256", wanted=f"that of {name}, {own[:12]}", found=str(told)[:12], do=do)


def with_run(before: Done, rows: Sequence[tuple[float, float]], presses: int, *, new_mounting: bool) -> Done:
    """What a further run adds: its presses, and the estimate of its last row where that is the narrower one.

    rows : as ``last_estimates`` has them.
    """
    kappa, low = before.kappa, before.low
    if rows and not (before.low > 0 and before.low / before.kappa > rows[-1][1] / rows[-1][0]):
        kappa, low = rows[-1]
    return Done(before.presses + presses, before.mountings + new_mounting, kappa, low)


def last_estimates(path: Path) -> list[tuple[float, float]]:
    """kappa and the lower end of its interval, of the last row of each press that tells them."""
    last: dict[str, tuple[float, float]] = {}
    try:
        with path.open(encoding="utf-8", newline="") as file:
            for row in csv.DictReader(file):
                if row["kappa_n_per_mm"] and row["low_n_per_mm"]:
                    last[row["repetition"]] = float(row["kappa_n_per_mm"]), float(row["low_n_per_mm"])
    except (OSError, ValueError, KeyError, TypeError):
        return []
    return list(last.values())


def _why(error: Exception) -> str:
    """Without the path, which the message names already."""
    return str((isinstance(error, OSError) and error.strerror) or error)


def _plan(path: Path) -> dict[str, Any]:
    try:
        plan = json.loads(path.read_text(encoding="utf-8"))["plan"]
        return {
            "specimen": str(plan["specimen"]),
            "angle_deg": float(plan["angle_deg"]),
            "condition": str(plan["condition"]),
        }
    except (OSError, ValueError, KeyError, TypeError) as error:
        do = "Name the folder of a run that rig run made."
        raise DataError(path, wanted="the plan of a run", found=_why(error), do=do) from error


@dataclass(frozen=True)
class AdaptiveRuns:
    """belief : of kappa, by all presses. pressed : by which calibration each run was chosen, and the run.
    completed : no run ended early. left : presses that were allowed and not needed."""

    belief: Believed
    pressed: tuple[tuple[str, Pressed], ...]
    completed: bool
    left: int


@dataclass
class Bench:
    """Where the specimen lies. place : angle and kind of actuator, None before the first run. mountings : index of a
    calibration to the mounting that it has pressed there."""

    place: tuple[float, bool] | None = None
    mountings: dict[int, int] = field(default_factory=dict)


def adaptive(
    file: RigFile, specimen: str, judging: Judging, *, presses: int | None = None, folder: str | Path | None = None,
    virtual: bool = False, person: Person = NOBODY,
) -> AdaptiveRuns:  # fmt: skip
    """Press an unknown specimen as `next_presses` says, until no further press is worthwhile.

    judging : a calibration for every angle and condition that may be pressed, and the width that is enough. presses :
    at most; None: those of the experiment for each calibration. Judged presses of the specimen in the folder of the
    runs count along. Else as `press`; SettingError, too, where nobody is there who mounts the specimen.

    >>> judging = rig.Judging((Path("modular_0.json"), Path("modular_30.json")), stop_at=0.1)
    >>> rig.adaptive(file, "S4", judging, virtual=True).belief
    """
    pressing = pressing_of(file, folder, virtual, person, presses=presses)
    root = pressing.root
    if not judging.calibrations:
        do = "Give one for every angle and condition that may be pressed."
        raise SettingError("judging", wanted="calibrations", found="none", do=do)
    opened = [open_calibration(path) for path in judging.calibrations]
    runs = tuple(chosen_runs(file, [specimen], [own.angle_deg], [own.condition], [1])[0] for own in opened)
    plans = pressing.plans(runs)
    kappas = judging.plans(file, plans, emulated=pressing.emulated)
    judged = {run: kappa for run, kappa in kappas.items() if kappa is not None}
    calibrations = [judged[run].calibration for run in runs]
    done = {index: _done_before(root, run, judged[run]) for index, run in enumerate(runs)}
    left = presses or file.experiment.repetitions * len(runs)
    bench, pressed, completed = Bench(), list[tuple[str, Pressed]](), True
    while left and (choice := next_press(calibrations, done, judging.stop_at or 0.0)):
        run, count = runs[choice.calibration], min(choice.presses, left)
        name, anew = judged[run].name, ", a new mounting" if choice.remount else ""
        person.say(f"kappa so far: {believed(calibrations, done)}")
        person.say(
            f"next: presses: {count}, by {name}{anew}; {choice.presses} are expected to leave "
            f"±{choice.half_width:.0%} of kappa"
        )
        mounting, new = mounted(bench, choice, runs, root, None if virtual else person)
        here, plan = run._replace(mounting=mounting), replace(plans[run], repetitions=count, mounting=mounting)
        pressing.check_same(here.name, plan)
        folder = next(each for each in folders_of(root, here.name) if not each.exists())
        one = pressing.press(plan, folder, judged[run])
        if virtual:
            person.warn(f"{folder.name}: {summary(one.ended, count)}")
        pressed.append((name, one))
        pressing.warn_unless_safe(one)
        if not (one.completed and one.left_safe):
            completed = False
            break
        told = last_estimates(folder / KAPPA_FILE)
        done[choice.calibration] = with_run(done[choice.calibration], told, count, new_mounting=new)
        left -= count
    return AdaptiveRuns(believed(calibrations, done), tuple(pressed), completed, left)


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


def mounted(bench: Bench, choice: Choice, runs: Sequence[Run], root: Path, person: Person | None) -> tuple[int, bool]:
    """Number of the mounting, and whether it is a new one; ``person`` is asked where a hand is needed.

    An emulated rig in virtual time mounts by itself, without a person. Conditions of the qbmove at one angle need no
    hand. Nor does the first run where all calibrations are of one place: the specimen lies there as for any other run.
    """
    run, places = runs[choice.calibration], {_place(run) for run in runs}
    again = choice.remount and choice.calibration in bench.mountings
    moved = bench.place != _place(run) and (bench.place is not None or len(places) > 1)
    if again or moved:
        if person is not None:
            _ask(run, person, anew=again)
        bench.mountings.clear()
    bench.place = _place(run)
    if number := bench.mountings.get(choice.calibration):
        return number, False
    number = bench.mountings[choice.calibration] = _next_mounting(root, run)
    return number, True


def _place(run: Run) -> tuple[float, bool]:
    return run.angle_deg, run.condition == RIGID


def _ask(run: Run, person: Person, *, anew: bool) -> None:
    under = "the rigid motor" if run.condition == RIGID else "the qbmove"
    todo = f"{'mount anew' if anew else 'put'} {run.specimen} at {run.angle_deg:g} degrees under {under}"
    if person.ask is None or person.ask(f"{todo[0].upper()}{todo[1:]}, then press Enter. ") is None:
        person.warn("")
        raise SettingError(
            "--adaptive", wanted=f"somebody to {todo}", found="the end of the standard input",
            do="Run it in a terminal; the same command goes on from the presses that are done.",
        )  # fmt: skip
