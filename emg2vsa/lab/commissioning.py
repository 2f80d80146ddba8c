"""Settings that are measured at the rig: what protects it, by a touch on a soft pad; the delay of the camera."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path

from emg2vsa.devices.clock import VirtualClock
from emg2vsa.errors import SettingError
from emg2vsa.lab.by_hand import hand_rig
from emg2vsa.lab.person import NOBODY, TRIES, Person
from emg2vsa.lab.pressing import emulated_of
from emg2vsa.lab.real_press import force_count
from emg2vsa.rig.commissioning.checks import REACH_DEG, Check, check_rig
from emg2vsa.rig.commissioning.hand_motion import HandMotion
from emg2vsa.rig.commissioning.reference import MOST_N, ReferenceProof, press_reference, write_reference
from emg2vsa.rig.open_rig import OpenRig
from emg2vsa.rig.record.new_folder import PLAN_FILE
from emg2vsa.rig.rig_settings import RigSettings
from emg2vsa.rig_file import RigFile, load_rig
from emg2vsa.rig_file.edit import write_values
from emg2vsa.rig_file.older_keys import spelled
from emg2vsa.run_folders.camera_delay import CameraDelay, measure_delay
from emg2vsa.study_file.problems import KeyPath
from emg2vsa.worlds.bench.bench import EmulatedRig

_BEGIN = """\
Put a soft pad flat on the force sensor, where the specimen lies.
The probe must be free, 3 to 5 mm above it. It moves slowly, 5 degrees of the shaft a second, to a touch of 0.5 N.
Any force of 0.5 N ends a move. Keep a hand on the switch of the power supply."""


_SPRING = """\
Put the flat plate on the probe, and a reference of {stated:g} N/mm on the force sensor: a spring, or a specimen whose
stiffness was measured elsewhere. The probe must be free, 3 to 5 mm above it. It presses until {most:g} N are felt.
Keep a hand on the switch of the power supply."""


def check_settings(
    file: RigFile, *, reach_deg: float = REACH_DEG, motor: bool = False, virtual: bool = False, person: Person = NOBODY
) -> tuple[Check, ...] | None:
    """push_axis, push_sign, gear, home and depth by a touch of 0.5 N on a soft pad; None where nobody is ready.

    virtual : on the emulated rig, which is built as the rig file says, in virtual time; it tells what a person would.
    reach_deg : farthest that the shaft may turn to reach the pad. Where nobody is asked the direction is searched, and
    the gear, which needs a calliper, is not checked. SettingError : a reach that cannot be. DeviceError : as `hand_rig`
    and `check_rig`.
    """
    _check_reach(reach_deg)
    if virtual:
        bench = EmulatedRig(
            emulated_of(file), file.experiment.specimens[0], 0.0, motor, VirtualClock(), rig=file.rig,
            actuator=file.devices.actuator,
        )  # fmt: skip
        hand = HandMotion(bench.devices(), file.rig, bench.clock)
        return check_rig(hand, file.rig, AtTheBench(bench), person.say, reach_deg)
    person.say(_BEGIN)
    if not person.agrees("Ready?"):
        return None
    with hand_rig(file, motor=motor) as (opened, hand):
        said = getattr(file.devices.actuator, joint.measured_key or "", None) if (joint := hand.joint) else None
        checks = check_rig(hand, opened.rig, AtThePad(person), person.say, reach_deg, said)
        return (*checks, *_numbers(opened, file))


def _numbers(opened: OpenRig, file: RigFile) -> Iterator[Check]:
    """Serial numbers that are told; one that is not as the file says has been refused before."""
    for table, told in opened.numbers.items():
        if told.number:
            said = getattr(file.devices, table).serial_number
            yield Check("serial_number", said, told.number, True, f"of [{table}], told by {told.by}", table)


def _check_reach(reach_deg: float) -> None:
    if not 0 < reach_deg <= 180:
        do = "Choose another."
        raise SettingError("--reach-deg", wanted="above 0 and at most 180", found=f"{reach_deg:g}", do=do)


_REFERENCE = "reference"
_SOFTEST, _STIFFEST = 1.0, 6.0
"""A softer one takes too long a way to 5 N, of a stiffer one too few readings are had."""


def check_reference(
    file: RigFile, stated_n_per_mm: float, *, reach_deg: float = REACH_DEG, motor: bool = False, virtual: bool = False,
    person: Person = NOBODY,
) -> ReferenceProof | None:  # fmt: skip
    """Press a reference of this stiffness, N/mm, with the flat plate, and keep what was found beside the rig file; None
    where nobody is ready.

    Runs of the rigid motor take its current as their second witness, for 12 hours, until the force sensor is switched
    off. reach_deg : of the shaft, degrees. virtual : on the emulated rig, for runs on that.
    SettingError : a reach or a stiffness that cannot be. DeviceError : as `hand_rig` and `press_reference`.
    """
    _check_reach(reach_deg)
    if not _SOFTEST <= stated_n_per_mm <= _STIFFEST:
        do = "Take another reference, and give its stiffness in N/mm."
        wanted = f"{_SOFTEST:g} to {_STIFFEST:g} N/mm"
        raise SettingError("--reference", wanted=wanted, found=f"{stated_n_per_mm:g}", do=do)

    def pressed(hand: HandMotion, rig: RigSettings, opened: OpenRig | None = None) -> ReferenceProof:
        first = opened and (force_count(file, opened), time.monotonic())
        speeds = sorted({file.plate.ramp_mm_per_s, file.experiment.ramp_mm_per_s})
        found, a_per_n = press_reference(hand, rig, speeds, reach_deg, person.say)
        counted, per_s, who = None, None, (0, "emulated", dict[str, str]())
        if opened and first:
            who = opened.info.device_id, opened.info.firmware, opened.serial_numbers
            counted, took_s = force_count(file, opened), time.monotonic() - first[1]
            per_s = None if counted is None or first[0] is None else (counted - first[0]) / took_s
        proof = ReferenceProof(
            datetime.now(UTC).isoformat(timespec="seconds"), stated_n_per_mm, found.n_per_mm, found.se_n_per_mm,
            tuple(a_per_n.items()), *who, rig.gear_mm_per_degree, rig.push_axis, counted, per_s,
        )  # fmt: skip
        person.say(f"written: {write_reference(file.path, proof, virtual=virtual)}")
        return proof

    if virtual:
        spring = replace(
            emulated_of(file), stiffness_n_per_mm={_REFERENCE: stated_n_per_mm}, height_mm={}, domes=None,
            relaxation={_REFERENCE: 0.0}, stiffness_sd=0.0, mounting_stiffness_sd=0.0,
        )  # fmt: skip
        bench = EmulatedRig(
            spring, _REFERENCE, 0.0, motor, VirtualClock(), rig=file.rig, plate=True, actuator=file.devices.actuator
        )
        return pressed(HandMotion(bench.devices(), file.rig, bench.clock), file.rig)
    person.say(_SPRING.format(stated=stated_n_per_mm, most=min(MOST_N, file.rig.guards.force_n / 2)))
    if not person.agrees("Ready?"):
        return None
    with hand_rig(file, motor=motor) as (opened, hand):
        return pressed(hand, opened.rig, opened)


def mend_settings(file: RigFile, checks: Sequence[Check], person: Person = NOBODY) -> bool:
    """Write what is wrong or new in ``checks`` into the rig file, in the units that it has; comments stay. Whether
    nothing is wrong now."""
    good = all(check.good for check in checks)
    wrong: dict[KeyPath, object] = {
        (check.table, check.key): check.found for check in checks if not check.good or check.new
    }
    if not wrong:
        person.say(f"{file.path}: these settings are right")
        return True
    wrong = spelled(file.path, wrong)
    if not person.agrees(f"Write {', '.join(str(key[-1]) for key in wrong)} into {file.path}?"):
        return good
    write_values(file.path, wrong)
    person.say(f"written: {file.path}; run emg2vsa rig commission once more to confirm it")
    return True


@dataclass(frozen=True)
class AtThePad:
    """What is asked while the probe touches the pad; nothing of a person who is not asked."""

    person: Person

    def towards(self, degrees: float) -> bool | None:
        """Which way the probe went."""
        if self.person.yes:
            return None
        question = f"The shaft has turned {degrees:g} degrees. Has the probe gone towards the pad? [y/n] "
        return self.person.answer(question, ("y", "yes", "n", "no")).startswith("y")

    def zero_calliper(self) -> None:
        """The gear is measured from here on."""
        self.person.answer(
            "The probe touches the pad. Set a calliper to zero there, if you have one, and press Enter. "
        )

    def moved_mm(self, degrees: float) -> float | None:
        """How far the probe went, mm, by a calliper; None where nobody says. degrees : that the shaft turned."""
        question = (
            f"The probe has gone back from the pad, {degrees:.2f} degrees of the shaft. How far, in mm, by a calliper? "
            "(Enter: not measured) "
        )
        for _ in range(TRIES):
            if not (said := self.person.answer(question)):
                break
            try:
                return float(said.replace(",", "."))
            except ValueError:
                self.person.say("Type a number of millimetres, such as 3.2.")
        return None


class AtTheBench:
    """What a person would see at the emulated rig."""

    def __init__(self, bench: EmulatedRig) -> None:
        self._bench = bench
        self._from_mm, self._touch_mm = bench.probe()[0], 0.0

    def towards(self, degrees: float) -> bool:
        """Which way the probe went."""
        return self._bench.probe()[0] > self._from_mm

    def zero_calliper(self) -> None:
        """The gear is measured from here on."""
        self._touch_mm = self._bench.probe()[0]

    def moved_mm(self, degrees: float) -> float:
        """How far the probe went, mm."""
        return abs(self._touch_mm - self._bench.probe()[0])


def camera_delay(paths: Sequence[str | Path]) -> CameraDelay:
    """The delay by the presses of ``paths``: folders of runs, or rig files for all their runs. It moves nothing.

    SettingError : a path is neither, or has no runs. RecordingError : as `measure_delay`.
    """
    if not paths:
        raise SettingError("paths", wanted="folders of runs, or rig files", found="none", do="Name one.")
    return measure_delay([folder for path in paths for folder in _folders(Path(path))])


def _folders(path: Path) -> list[Path]:
    if path.is_dir():
        return [path]
    if not path.exists():
        raise SettingError(path, wanted="the folder of a run, or a rig file", found="neither", do="Check the path.")
    runs = load_rig(path).runs
    if not (folders := sorted(plan.parent for plan in runs.glob(f"*/{PLAN_FILE}"))):
        do = "Press first: emg2vsa rig run."
        raise SettingError(path, wanted=f"runs in {runs}", found="none", do=do)
    return folders
