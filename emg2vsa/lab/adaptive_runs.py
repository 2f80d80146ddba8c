"""Run after run of one unknown specimen, each chosen by what the presses before it told of its stiffness."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import takewhile
from pathlib import Path

from emg2vsa.calibration.next_press import Choice, Done, next_press
from emg2vsa.calibration_file import open_calibration
from emg2vsa.errors import SettingError
from emg2vsa.lab.ending import summary
from emg2vsa.lab.judging import Judging
from emg2vsa.lab.next_press import Believed, believed, check_judged_by, last_estimates, with_run
from emg2vsa.lab.person import NOBODY, Person
from emg2vsa.lab.pressed import Pressed
from emg2vsa.lab.pressing import pressing_of
from emg2vsa.rig.kappa.live_kappa import KAPPA_FILE, KappaPlan
from emg2vsa.rig.plan import RIGID
from emg2vsa.rig.record.new_folder import folders_of
from emg2vsa.rig_file import RigFile
from emg2vsa.rig_file.plans import Run, chosen_runs


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
