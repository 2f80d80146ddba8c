"""Everything that goes wrong in the fault matrix of the Dynamixel, and how a run may end by it.

A motor that gives way itself has no place where it ought to be: what the guard of the motors' way tells of a qbmove,
here the springs tell, or the current, or a depth, or an encoder that stays the same while the force grows.
"""

from __future__ import annotations

from dataclasses import replace

from benchmarks.rig.fault_bench import SPECIMEN, Built
from benchmarks.rig.fault_case import TOP
from benchmarks.rig.faults import (
    BLIND,
    CAMERA_FAULTS,
    CURRENT,
    DISK_FAULTS,
    ENDINGS,
    FOLLOWING,
    FORCE_FAULTS,
    LINE_FAULTS,
    LOOP_FAULTS,
    LOST_ACTUATOR,
    NO_CONTACT,
    PAST_CONTACT,
    PRELOAD,
    RATE,
    REFUSED,
    REFUSED_FILE,
    REFUSED_SCHEDULE,
    REJECTED,
    SPRINGS,
    SURVIVED,
    TRAVEL,
    UNTRUSTED,
    WAY_HOME,
    End,
    Fault,
    actuator_fault,
    words,
)
from emg2vsa.devices.dynamixel import DynamixelSettings
from emg2vsa.rig.rig_settings import RigSettings
from emg2vsa.worlds.far_ends.dynamixel.table import XM430_W350

GAIN, D_GAIN, GEAR_MM_PER_DEGREE, GOAL_A = 800, 1500, 0.8, 0.4
FULL = XM430_W350.stiffness_nm_per_rad(GAIN)
TRUE = RigSettings(gear_mm_per_degree=GEAR_MM_PER_DEGREE, full_preset=FULL, max_mm_per_s=20.0)
"""Faster, the motor's damping alone looks like a force of more than the guard allows between joint and sensor."""
AT_REST = End("guard", "springs at rest")


def built(goal_current_a: float = GOAL_A, told: RigSettings | None = None, specimen: str = SPECIMEN) -> Built:
    """The bench with a Dynamixel; what it may draw caps the force."""
    motor = DynamixelSettings(
        kind="dynamixel", full_gain=GAIN, d_gain=D_GAIN, full_stiffness_nm_per_rad=FULL, goal_current_a=goal_current_a
    )
    return Built(actuator=motor, true=TRUE, told=told, specimen=specimen)


def cap_n(goal_current_a: float) -> float:
    """Largest force of a motor that draws so much, N."""
    return XM430_W350.torque_constant_nm_per_a * goal_current_a / TRUE.lever_m


STANDS = (FOLLOWING, SPRINGS, AT_REST, UNTRUSTED, CURRENT, NO_CONTACT, PAST_CONTACT, PRELOAD, TRAVEL, WAY_HOME)
"""How a shaft is seen that does not go where it is told, or an encoder that does not tell where it is."""


def _motor(line: str, *ends: End, **more: object) -> Fault:
    return actuator_fault(line, *ends, **more)


MOTOR_FAULTS: dict[str, Fault] = {
    "commands ignored 0.5 s": _motor("ignore for 0.5 s", *STANDS, LOST_ACTUATOR, SURVIVED, probe="left"),
    "commands ignored 1.5 s": _motor("ignore for 1.5 s", *STANDS, LOST_ACTUATOR, probe="left"),
    "commands ignored for ever": _motor("ignore", *STANDS, LOST_ACTUATOR, probe="left"),
    "gear jammed": _motor("jam", *STANDS, probe="left"),
    "gear jammed 1 s": _motor("jam for 1 s", *STANDS, probe="left"),
    "supply broken down": _motor("brown-out", LOST_ACTUATOR, REFUSED, probe="left"),
    "supply broken down for 1 s": _motor("brown-out for 1 s", LOST_ACTUATOR, REFUSED, probe="left"),
    "supply of 17 V": _motor("supply 17", LOST_ACTUATOR, REFUSED, probe="left"),
    "motor weak": _motor("weak 0.02", *STANDS, probe="left"),
    "encoder frozen": _motor("frozen-shaft", *STANDS, probe="left"),
    "encoder reads 90 degrees more": _motor("jumped-shaft 90", *STANDS, LOST_ACTUATOR, probe="left"),
    "encoder reads 90 degrees less": _motor("jumped-shaft -90", *STANDS, LOST_ACTUATOR, probe="left"),
    "encoder reads 20 degrees less": _motor("jumped-shaft -20", *STANDS, probe="left"),
    "encoder reads 5 degrees more": _motor("jumped-shaft 5", *STANDS, probe="left"),
    "encoder reads 5 degrees less": _motor("jumped-shaft -5", *STANDS, probe="left"),
    "encoder reads 1 degree less": _motor("jumped-shaft -1", *STANDS, SURVIVED, REJECTED, probe="left"),
    "current reads 2 A more": Fault(words("current"), (CURRENT,), later=True),
    "motor of 90 degrees C": _motor("hot 90", LOST_ACTUATOR, REFUSED, probe="left"),
    "overload told": _motor("overload", LOST_ACTUATOR, REFUSED, probe="left"),
    "electrical shock told": _motor("shock", LOST_ACTUATOR, REFUSED, probe="left"),
    "broken encoder told": _motor("broken-encoder", LOST_ACTUATOR, REFUSED, probe="left"),
    "watchdog forgotten": Fault(words("no-watchdog"), (SURVIVED,), REFUSED),
    "watchdog says so only": Fault(words("flag-only"), (SURVIVED,)),
}
FAULTS = LINE_FAULTS | MOTOR_FAULTS | LOOP_FAULTS | FORCE_FAULTS | CAMERA_FAULTS | DISK_FAULTS | ENDINGS
FAULTS["force jumps"] = replace(FAULTS["force jumps"], ends=(RATE, UNTRUSTED))  # the springs tell it, too
del FAULTS["program killed, watchdog frame lost"]  # the motor reads it back, and a frame that is lost is sent again

WRONG_RIGS: dict[str, tuple[RigSettings, tuple[End, ...]]] = {
    "push_axis along x": (replace(TRUE, push_axis=(1.0, 0.0, 0.0)), BLIND),
    "push_axis upside down": (replace(TRUE, push_axis=(0.0, 0.0, -1.0)), BLIND),
    "push_sign upside down": (replace(TRUE, push_sign=-1), (TRAVEL, NO_CONTACT, SPRINGS)),
    "home 9 mm too deep": (replace(TRUE, home_deg=11.25), (WAY_HOME, PRELOAD, SPRINGS)),
    "home 4 mm too deep": (replace(TRUE, home_deg=5.0), (WAY_HOME, PRELOAD, SPRINGS)),
    "gear of 0.4 for 0.8": (replace(TRUE, gear_mm_per_degree=0.4), (REFUSED_FILE, REFUSED_SCHEDULE)),
    "gear of 1.6 for 0.8": (replace(TRUE, gear_mm_per_degree=1.6), (REFUSED_FILE, REFUSED_SCHEDULE)),
    "filter of 2000 samples": (replace(TRUE, filter_samples=2000), (REFUSED_FILE, SPRINGS)),
    "loop at 1000 Hz": (replace(TRUE, rate_hz=1000.0), (SURVIVED, REFUSED_FILE)),
}


def ends_in(fault: Fault, phase: str) -> tuple[End, ...]:
    """How the run may end: its activation takes no time on this bench, and near the end of the load much is too
    late to show."""
    if phase == "activation":
        return (*fault.ends, *((fault.activation,) if fault.activation else ()), *((REFUSED,) if fault.later else ()))
    if phase == TOP:
        late = fault.harmless_in or fault.unseen_in or fault.later
        return (*fault.ends, SURVIVED) if late else fault.ends
    return fault.ends_in(phase)
