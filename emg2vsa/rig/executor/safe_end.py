"""The way out of every run: probe away from the specimen, motors off."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from emg2vsa.errors import DeviceError
from emg2vsa.rig.clock import Clock
from emg2vsa.rig.devices import Actuator
from emg2vsa.rig.executor.motion import towards_home
from emg2vsa.rig.rig_settings import RigSettings

_OFF_ATTEMPTS = 3
_THERE_MM = 0.2
"""Motors so close to the retracted position have reached it."""


@dataclass(frozen=True)
class SafeEnd:
    """What was reached, and what went wrong on the way."""

    retracted: bool
    deactivated: bool
    notes: tuple[str, ...]


def make_safe(
    actuator: Actuator,
    rig: RigSettings,
    clock: Clock,
    start: tuple[float, int] | None,
    log: Callable[[int, int], None],
) -> SafeEnd:
    """Retract from ``start`` (depth in mm, preset in ticks), wait until the motors have followed, switch them off.

    Nothing keeps it from trying all of that, not even another Ctrl-C: a ramp that fails or is cut short is replaced by
    one command to the retracted position. None as ``start``: nothing is known to have moved, so only motors off.
    Retracted is what the encoders say, for motors that have gone off by themselves obey no command.
    ``log`` is told every position and preset; its DeviceError is noted.
    """
    notes: list[str] = []
    retracted = start is not None and (
        _tried(lambda: _ramp(actuator, rig, clock, *start, log, notes), notes)
        or _tried(lambda: actuator.set_position_stiffness(rig.ticks_at(0.0), start[1]), notes)
    )
    if retracted:
        _tried(lambda: clock.sleep_until(clock.now_s() + rig.settle_s), notes)
        retracted = _tried(lambda: _check_retracted(actuator, rig), notes)
    deactivated = any(_tried(actuator.deactivate, notes) for _ in range(_OFF_ATTEMPTS))
    return SafeEnd(retracted, deactivated, tuple(dict.fromkeys(notes)))


def _ramp(
    actuator: Actuator,
    rig: RigSettings,
    clock: Clock,
    depth_mm: float,
    preset_ticks: int,
    log: Callable[[int, int], None],
    notes: list[str],
) -> None:
    while True:
        depth_mm = towards_home(depth_mm, rig.escape_mm_per_s * rig.period_s)
        position_ticks = rig.ticks_at(depth_mm)
        actuator.set_position_stiffness(position_ticks, preset_ticks)
        try:
            log(position_ticks, preset_ticks)
        except DeviceError as error:
            notes.append(str(error))
        if depth_mm == 0:
            return
        clock.sleep_until(clock.now_s() + rig.period_s)


def _check_retracted(actuator: Actuator, rig: RigSettings) -> None:
    depth_mm = rig.depth_at(actuator.position_ticks())
    if abs(depth_mm) > _THERE_MM:
        raise DeviceError(
            "probe",
            wanted="motors at the retracted position",
            found=f"{depth_mm:.1f} mm from it",
            do="Take it away from the specimen by hand, or by the next run.",
        )


def _tried(action: Callable[[], None], notes: list[str]) -> bool:
    try:
        action()
    except BaseException as error:
        notes.append(f"{type(error).__name__}: {error}".removesuffix(": "))
        return False
    return True
