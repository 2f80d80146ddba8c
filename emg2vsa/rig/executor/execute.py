"""Carry out a plan: loop at 200 Hz, guards in every turn, and one way out for every end (paper, section V)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import closing
from datetime import datetime
from pathlib import Path
from typing import Any

from emg2vsa.devices.clock import Beat, Clock, ahead
from emg2vsa.devices.protocols import Devices, PressJudge
from emg2vsa.durable.writer import Writer
from emg2vsa.rig.executor.control_cycle import ControlCycle
from emg2vsa.rig.executor.guards import GUARDS, Check
from emg2vsa.rig.executor.plan_limits import check_plan, check_rating
from emg2vsa.rig.executor.safe_end import SafeEnd, make_safe
from emg2vsa.rig.plan import RunPlan
from emg2vsa.rig.record.ended import Ended, EndRun, busy_loop
from emg2vsa.rig.record.run_record import RunRecord
from emg2vsa.rig.rig_settings import RigSettings

_SEEMS_LOST = ("lost device", "stale sensor", "lost camera", "overrun")
"""Causes that a loop held up by a busy computer brings about as well."""


def execute(
    plan: RunPlan,
    rig: RigSettings,
    devices: Devices,
    folder: Path,
    clock: Clock,
    *,
    started: datetime,
    stop: Callable[[], str | None] = lambda: None,
    facts: Mapping[str, Any] | None = None,
    background: bool = False,
    guards: Mapping[str, Check] = GUARDS,
    judge: PressJudge | None = None,
) -> Ended:
    """Run ``plan`` and record it in ``folder``; how it ended.

    Whatever the end, the probe is retracted, the motors are switched off, and ended.json says how, when and why.
    ``stop`` is asked in every turn, and ends the run by naming a reason: a signal that has come, a button. ``started``
    is the date and time at 0 s of ``clock``. ``facts`` : what the devices say of themselves, for plan.json.
    ``background`` : a thread writes to the disk, so that the loop never waits for it; wanted where time is real.
    ``guards`` : name to check, all asked in every turn; not copied, so that what is added to them later counts too.
    ``judge`` : is shown the frames and forces of each press, and may end its loading before F_max.

    Raises
    ------
    SettingError, ScheduleError : the plan, or a guard, breaks a limit; nothing has been sent.
    DeviceError : ``folder`` cannot be recorded to, or holds a run; nothing has been sent.
    Any error of the program itself, after the safe end.
    """
    check_plan(plan, rig)
    check_rating(rig, devices.force.rating)
    with closing(Writer(background=background)) as writer:
        seen = devices.camera
        record = RunRecord(
            folder, started, seen.shape if seen else None, devices.actuator.columns,
            delay_s=seen.delay_s if seen else 0.0, writer=writer, force_counts=devices.force.counts, judge=judge,
        )  # fmt: skip
        record.plan(plan, rig, facts)
        with ahead():
            cycle = ControlCycle(plan, rig, devices, record, clock, guards)
            return _recorded(plan, rig, devices, record, clock, stop, cycle)


def _recorded(
    plan: RunPlan,
    rig: RigSettings,
    devices: Devices,
    record: RunRecord,
    clock: Clock,
    stop: Callable[[], str | None],
    cycle: ControlCycle,
) -> Ended:
    beat = Beat(clock, rig.period_s)
    end = EndRun("interrupted", "Ctrl-C", "interrupted at the keyboard")
    try:
        _press_all(cycle, beat, record, stop)
        end = EndRun("completed", "", "")
    except EndRun as reason:
        end = reason
    except KeyboardInterrupt:
        pass
    except BaseException as error:
        end = EndRun("failed", type(error).__name__, str(error))
        raise
    finally:
        ended = _finish(end, plan, rig, devices, cycle, record, beat, clock)
    return ended


def _press_all(cycle: ControlCycle, beat: Beat, record: RunRecord, stop: Callable[[], str | None]) -> None:
    cycle.start()
    beat.restart()
    while True:
        if reason := stop():
            raise EndRun("stopped", reason, "asked to stop")
        now_s, late_s = beat.wait()
        motion = cycle.turn(now_s, late_s)
        if motion.phase == "done":
            return
        if motion.since_s == now_s and motion.phase == "retract":
            record.end_loading(now_s)
        elif motion.since_s == now_s and motion.phase == "pause":
            record.end_press()


def _finish(
    end: EndRun,
    plan: RunPlan,
    rig: RigSettings,
    devices: Devices,
    cycle: ControlCycle,
    record: RunRecord,
    beat: Beat,
    clock: Clock,
) -> Ended:
    motion, time_s = cycle.motion, clock.now_s()
    safe = make_safe(devices.actuator, rig, clock, cycle.retreat_from(), cycle.log_escape)
    end = _truly(end, safe, record)
    timing = beat.timing()
    busy = busy_loop(timing)
    why = f"{end.why} {busy}" if busy and end.cause in _SEEMS_LOST else end.why
    return record.end(
        Ended(
            end.how, end.cause, why, "activation" if motion is None else motion.phase,
            0 if motion is None else motion.repetition, time_s, "",
            retracted=safe.retracted, deactivated=safe.deactivated, timing=timing,
            notes=(*safe.notes, busy) if busy else safe.notes,
            peak_force_n=cycle.peak_force_n, last_force_n=safe.last_force_n,
        )
    )  # fmt: skip


def _truly(end: EndRun, safe: SafeEnd, record: RunRecord) -> EndRun:
    """A run is completed only where every press is whole and the probe is away."""
    if end.how != "completed":
        return end
    if not safe.retracted:
        return EndRun("rejected", "not retracted", "; ".join(safe.notes))
    if record.rejected:
        return EndRun("rejected", "press", "; ".join(record.rejected))
    return end
