"""Options of rig run that judge a press while it goes on: the calibrations, and the width at which a press may stop."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from casr.command_line import Group

if TYPE_CHECKING:
    from casr.camera import Camera
    from emg2vsa.calibration.online import OnlineCalibration
    from emg2vsa.rig.kappa.live_kappa import KappaPlan
    from emg2vsa.rig.plan import RunPlan
    from emg2vsa.rig_file import RigFile
    from emg2vsa.rig_file.plans import Run

KappaPlans = Callable[["Mapping[Run, RunPlan]"], "Mapping[Run, KappaPlan | None]"]
"""What ``kappa_plans`` says of the runs that are chosen."""
_WIDTHS = (0.5, 100.0)
_SAME_DEG = 1e-6


def add_kappa(parser: Group) -> None:
    """Kappa while the finger presses."""
    parser.add_argument(
        "--calibration",
        type=Path,
        action="append",
        default=[],
        metavar="FILE",
        help="judge the stiffness of the specimen while it is pressed, by this calibration of emg2vsa run; repeat it "
        "for other angles and conditions. kappa.csv in the folder of the run has a row for each frame",
    )
    parser.add_argument(
        "--stop-at",
        type=width,
        metavar="PERCENT",
        help="with --calibration: end the loading of a press when the 95 %% interval of kappa reaches no more than "
        "this share of kappa to either side, or when the rest of the press would narrow it by less than a tenth. Such "
        "a press "
        "counts as done, and is marked as stopped",
    )
    parser.add_argument(
        "--adaptive",
        action="store_true",
        help="with --calibration and one --specimen: choose stiffness preset, angle and number of presses of each next "
        "run as emg2vsa rig next does, until --stop-at is reached or no press would narrow the interval by a tenth. "
        "Judged presses of the specimen in the folder of the runs count along. The command asks where an angle or a "
        "mounting must be changed by hand",
    )
    parser.add_argument(
        "--camera",
        type=Path,
        metavar="FILE",
        help="with --calibration: camera.toml of the tactile camera (default: camera.toml beside the rig file; an "
        "emulated rig has its own)",
    )


def width(text: str) -> float:
    """``5`` or ``5%`` as 0.05."""
    try:
        percent = float(text.removesuffix("%").strip())
    except ValueError:
        percent = float("nan")
    low, high = _WIDTHS
    if not low <= percent <= high:
        raise argparse.ArgumentTypeError(
            f"expected a percentage of kappa from {low:g} to {high:g}, such as 5, but found {text!r}"
        )
    return percent / 100


def kappa_plans(
    arguments: argparse.Namespace, file: RigFile, plans: Mapping[Run, RunPlan]
) -> Mapping[Run, KappaPlan | None]:
    """How the presses of each run are judged; None where no calibration was asked for.

    SettingError, DataError, CameraError : a calibration, an option or a camera file that does not fit; nothing has
    moved.
    """
    from emg2vsa.calibration_file import open_calibration
    from emg2vsa.errors import SettingError
    from emg2vsa.rig.kappa.live_kappa import KappaPlan

    for name in ("stop_at", "camera"):
        if getattr(arguments, name) is not None and not arguments.calibration:
            option = f"--{name.replace('_', '-')}"
            do = "Add --calibration FILE, or leave it out."
            raise SettingError(option, wanted="--calibration beside this option", found="none", do=do)
    if not arguments.calibration:
        return dict.fromkeys(plans)
    opened = {path: open_calibration(path) for path in arguments.calibration}
    emulated = arguments.virtual or file.leads_to_emulated
    judged: dict[Run, KappaPlan | None] = {}
    for run in plans:
        path, calibration = _of_run(run, opened)
        if calibration.simulated and not emulated:
            raise SettingError(
                path, wanted="a calibration by presses of a real rig", found="one by presses of an emulated rig",
                do="Press known specimens with this rig and run the study, or add --virtual.",
            )  # fmt: skip
        if plans[run].f_max_n < calibration.forces_n[0]:
            raise SettingError(
                file.path, wanted=f"presses beyond {calibration.forces_n[0]:g} N, where {path.name} begins",
                found=f"f_max_n = {plans[run].f_max_n:g}", do="Press harder, or calibrate from a smaller force on.",
            )  # fmt: skip
        camera = _camera(arguments, file, run, calibration, emulated=emulated)
        judged[run] = KappaPlan(path.name, calibration, camera, arguments.stop_at)
    return judged


def say_reachable(kappa: KappaPlan, plan: RunPlan, *, emulated: bool) -> None:
    """What widths can be expected, before the first press."""
    from emg2vsa.calibration.online import reachable_width

    own, presses = kappa.calibration, plan.repetitions
    one, all_of_them = (reachable_width(own, None, n, plan.f_max_n) for n in (1, presses))
    known = f"{', '.join(own.specimens)}, {counted(own.presses)}"
    print(f"kappa: by {kappa.name} ({known}); at best ±{one:.0%} of kappa by one press", end="")
    print(f", ±{all_of_them:.0%} by {presses}" if presses > 1 else "", flush=True)
    if kappa.stop_at is not None and kappa.stop_at < all_of_them:
        print(
            f"emg2vsa: a width of ±{kappa.stop_at:.1%} cannot be reached with this calibration and the scatter of its "
            f"presses; ±{all_of_them:.1%} is the narrowest that {counted(presses)} of any stiffness can be "
            "expected to reach. Presses end where the rest would narrow the interval by less than a tenth.",
            file=sys.stderr,
        )
    for note in _notes(kappa, plan, emulated=emulated):
        print(f"emg2vsa: {note}", file=sys.stderr)


def _notes(kappa: KappaPlan, plan: RunPlan, *, emulated: bool) -> Iterator[str]:
    """What of these presses is unlike those of the calibration."""
    own = kappa.calibration
    if emulated and not own.simulated:
        yield f"{kappa.name} is by presses of a real rig, and an emulated one presses here: kappa may be far off."
    if plan.f_max_n < own.forces_n[-1]:
        yield (
            f"{kappa.name} reaches to {own.forces_n[-1]:g} N, and these presses turn back at {plan.f_max_n:g} N: kappa "
            "is told up to there."
        )


def counted(presses: int) -> str:
    """``1 press``, ``2 presses``."""
    return f"{presses} press" if presses == 1 else f"{presses} presses"


def say_kappa(folder: Path) -> None:
    """What the presses of the run in ``folder`` have told of kappa."""
    from emg2vsa.rig.kappa.live_kappa import KAPPA_FILE, last_rows
    from emg2vsa.rig.record.new_folder import KAPPA_ABOUT_FILE

    for row in last_rows(folder / KAPPA_FILE):
        print(f"kappa after press {row.repetition}: {row.told()}")
    try:
        about = json.loads((folder / KAPPA_ABOUT_FILE).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return
    if about["dropped"] or about["trouble"]:
        lost = f"{about['dropped']} of {about['frames']} frames were left out by the estimator, none by the recording"
        why = about["trouble"] and f"the estimator: {about['trouble']}"
        print(f"kappa: {'; '.join(filter(None, (lost, why)))}", file=sys.stderr)


def _of_run(run: Run, opened: Mapping[Path, OnlineCalibration]) -> tuple[Path, OnlineCalibration]:
    from emg2vsa.errors import SettingError

    fitting = [
        (path, each)
        for path, each in opened.items()
        if abs(each.angle_deg - run.angle_deg) < _SAME_DEG and each.condition == run.condition
    ]
    if len(fitting) == 1:
        return fitting[0]
    there = ", ".join(f"{path.name}: {each.angle_deg:g} degrees, {each.condition}" for path, each in opened.items())
    raise SettingError(
        "--calibration",
        wanted=f"one calibration for {run.angle_deg:g} degrees, {run.condition}",
        found=there,
        do="Give the calibration of this angle and condition, or choose another run.",
    )


def _camera(
    arguments: argparse.Namespace, file: RigFile, run: Run, calibration: OnlineCalibration, *, emulated: bool
) -> Camera | None:
    from casr.frame_files import read_camera
    from emg2vsa.errors import SettingError

    if calibration.area_unit == "px2":
        if arguments.camera is None:
            return None
        do = "Leave out --camera, or calibrate with a camera file."
        raise SettingError("--camera", wanted="a calibration in mm2", found="one in px2", do=do)
    if arguments.camera is None and emulated:
        return emulated_camera(file, run)
    path = arguments.camera or file.path.parent / "camera.toml"
    if arguments.camera is None and not path.is_file():
        raise SettingError(
            path, wanted="the camera file of the tactile camera: the calibration is in mm2", found="no such file",
            do="Give it with --camera FILE; casr calibrate makes one.",
        )  # fmt: skip
    return read_camera(path)


def emulated_camera(file: RigFile, run: Run) -> Camera:
    """What the emulated rig sees a specimen with."""
    from emg2vsa.rig.clock import VirtualClock
    from emg2vsa.rig.emulated.bench import EmulatedRig
    from emg2vsa.settings import RIGID

    assert file.emulated is not None
    bench = EmulatedRig(
        file.emulated, run.specimen, run.angle_deg, run.condition == RIGID, VirtualClock(), rig=file.rig
    )
    return bench.camera.scene.settings.camera
