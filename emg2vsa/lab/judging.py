"""How presses are judged while they go on: by which calibrations, until what width, and what is said of it."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from casr.camera import Camera
from casr.frame_files import read_camera
from emg2vsa.calibration.online import OnlineCalibration, reachable_width
from emg2vsa.calibration_file import open_calibration
from emg2vsa.devices.clock import VirtualClock
from emg2vsa.errors import SettingError
from emg2vsa.lab.person import Person
from emg2vsa.rig.kappa.live_kappa import KAPPA_FILE, KappaPlan, last_rows
from emg2vsa.rig.plan import RIGID, RunPlan
from emg2vsa.rig.record.new_folder import KAPPA_ABOUT_FILE
from emg2vsa.rig_file import RigFile
from emg2vsa.rig_file.plans import Run
from emg2vsa.worlds.bench.bench import EmulatedRig

_SAME_DEG = 1e-6


@dataclass(frozen=True)
class Judging:
    """Judging the stiffness kappa while the finger presses; without a calibration presses are not judged.

    calibrations : files of emg2vsa run, one for each angle and condition that is pressed.
    stop_at : a press ends its loading when the 95 % interval of kappa reaches no more than this share of kappa to
    either side, or when the rest of the press would narrow it by less than a tenth; None: presses go on to F_max.
    camera : camera.toml of the tactile camera; None: the one beside the rig file, or that of the emulated rig.
    domes, specimen_height_mm : folder of the sensor's own tables of domes, as the calibration's study has it, and the
    thickness of the specimen; see casr.ScoreSettings.
    """

    calibrations: tuple[Path, ...] = ()
    stop_at: float | None = None
    camera: Path | None = None
    domes: Path | None = None
    specimen_height_mm: float | None = None

    def plans(self, file: RigFile, plans: Mapping[Run, RunPlan], *, emulated: bool) -> Mapping[Run, KappaPlan | None]:
        """How the presses of each run are judged; None where no calibration was asked for.

        SettingError, DataError, CameraError : a calibration, an option or a camera file that does not fit; nothing has
        moved.
        """
        asked = {
            "--stop-at": self.stop_at, "--camera": self.camera, "--domes": self.domes,
            "--specimen-height-mm": self.specimen_height_mm,
        }  # fmt: skip
        for option, value in asked.items():
            if value is not None and not self.calibrations:
                do = "Add --calibration FILE, or leave it out."
                raise SettingError(option, wanted="--calibration beside this option", found="none", do=do)
        if not self.calibrations:
            return dict.fromkeys(plans)
        opened = {path: open_calibration(path) for path in self.calibrations}
        return {run: self._plan(file, run, plan, opened, emulated=emulated) for run, plan in plans.items()}

    def _plan(
        self, file: RigFile, run: Run, plan: RunPlan, opened: Mapping[Path, OnlineCalibration], *, emulated: bool
    ) -> KappaPlan:
        path, calibration = _of_run(run, opened)
        if calibration.simulated and not emulated:
            raise SettingError(
                path, wanted="a calibration by presses of a real rig", found="one by presses of an emulated rig",
                do="Press known specimens with this rig and run the study, or add --virtual.",
            )  # fmt: skip
        if plan.f_max_n < calibration.forces_n[0]:
            raise SettingError(
                file.path, wanted=f"presses beyond {calibration.forces_n[0]:g} N, where {path.name} begins",
                found=f"f_max_n = {plan.f_max_n:g}", do="Press harder, or calibrate from a smaller force on.",
            )  # fmt: skip
        if bool(known := calibration.domes) != bool(self.domes):
            wanted = f"the tables of domes that {path.name} was made with, {known}" if known else "no tables of domes"
            do = "Give their folder." if known else f"Leave it out: {path.name} was made with those of casr."
            raise SettingError("--domes", wanted=wanted, found=str(self.domes or "none"), do=do)
        camera = self._camera(file, run, calibration, emulated=emulated)
        domes = str(self.domes) if self.domes else None
        found = KappaPlan(path.name, calibration, camera, self.stop_at, domes, self.specimen_height_mm)
        found.worlds()  # an error in them is told before anything moves
        if (pins := calibration.pins) is not None:
            pins.family(found.tables())
            if not pins.camera.sees_like(camera):
                raise SettingError(
                    "--camera", wanted=f"the camera that {path.name} was made with", found=f"another, {camera}",
                    do="Give its camera.toml, or press the known specimens with this camera and run the study.",
                )  # fmt: skip
        return found

    def _camera(self, file: RigFile, run: Run, calibration: OnlineCalibration, *, emulated: bool) -> Camera | None:
        if calibration.area_unit == "px2":
            if self.camera is None:
                return None
            do = "Leave out --camera, or calibrate with a camera file."
            raise SettingError("--camera", wanted="a calibration in mm2", found="one in px2", do=do)
        if self.camera is None and emulated:
            return _emulated_camera(file, run)
        path = self.camera or file.path.parent / "camera.toml"
        if self.camera is None and not path.is_file():
            raise SettingError(
                path, wanted="the camera file of the tactile camera: the calibration is in mm2", found="no such file",
                do="Give it with --camera FILE; casr calibrate makes one.",
            )  # fmt: skip
        return read_camera(path)


WHOLE_PRESSES = Judging()
"Nobody judges."


def say_reachable(kappa: KappaPlan, plan: RunPlan, person: Person, *, emulated: bool) -> None:
    """What widths can be expected, before the first press."""
    own, presses = kappa.calibration, plan.repetitions
    one, all_of_them = (reachable_width(own, None, n, plan.f_max_n) for n in (1, presses))
    known = f"{', '.join(own.specimens)}, {_counted(own.presses)}"
    several = f", ±{all_of_them:.0%} by {presses}" if presses > 1 else ""
    person.say(f"kappa: by {kappa.name} ({known}); at best ±{one:.0%} of kappa by one press{several}")
    if kappa.stop_at is not None and kappa.stop_at < all_of_them:
        person.hint(
            f"emg2vsa: a width of ±{kappa.stop_at:.1%} cannot be reached with this calibration and the scatter of its "
            f"presses; ±{all_of_them:.1%} is the narrowest that {_counted(presses)} of any stiffness can be "
            "expected to reach. Presses end where the rest would narrow the interval by less than a tenth."
        )
    for unlike in _unlike(kappa, plan, emulated=emulated):
        person.hint(f"emg2vsa: {unlike}")


def _unlike(kappa: KappaPlan, plan: RunPlan, *, emulated: bool) -> Iterator[str]:
    """What of these presses is unlike those of the calibration."""
    own = kappa.calibration
    if emulated and not own.simulated:
        yield f"{kappa.name} is by presses of a real rig, and an emulated one presses here: kappa may be far off."
    if plan.f_max_n < own.forces_n[-1]:
        yield (
            f"{kappa.name} reaches to {own.forces_n[-1]:g} N, and these presses turn back at {plan.f_max_n:g} N: kappa "
            "is told up to there."
        )


def _counted(presses: int) -> str:
    return f"{presses} press" if presses == 1 else f"{presses} presses"


def say_kappa(folder: Path, person: Person) -> None:
    """What the presses of the run in ``folder`` have told of kappa."""
    for row in last_rows(folder / KAPPA_FILE):
        person.say(f"kappa after press {row.repetition}: {row.told()}")
    try:
        about = json.loads((folder / KAPPA_ABOUT_FILE).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return
    if about["dropped"] or about["trouble"]:
        lost = f"{about['dropped']} of {about['frames']} frames were left out by the estimator, none by the recording"
        why = about["trouble"] and f"the estimator: {about['trouble']}"
        person.hint(f"kappa: {'; '.join(filter(None, (lost, why)))}")


def _of_run(run: Run, opened: Mapping[Path, OnlineCalibration]) -> tuple[Path, OnlineCalibration]:
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


def _emulated_camera(file: RigFile, run: Run) -> Camera:
    """Camera with which the emulated rig sees a specimen."""
    assert file.emulated is not None
    rigid, clock = run.condition == RIGID, VirtualClock()
    bench = EmulatedRig(file.emulated, run.specimen, run.angle_deg, rigid, clock, rig=file.rig)
    return bench.camera.scene.settings.camera
