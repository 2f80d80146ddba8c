"""How a run ended, for people."""

from __future__ import annotations

from pathlib import Path

from emg2vsa.devices.clock import LoopTiming
from emg2vsa.rig.record.ended import Ended
from emg2vsa.rig.rig_settings import RigSettings


def told(ended: Ended, repetitions: int, folder: Path, rig: RigSettings) -> str:
    """How, cause and why, presses done, where motors and files were left, and the timing of the control loop."""
    lines = [summary(ended, repetitions)]
    probe = "probe retracted" if ended.retracted else "probe NOT retracted"
    lines.append(f"left: {probe}, motors {'off' if ended.deactivated else 'NOT confirmed off'}")
    lines += [f"note: {note}" for note in ended.notes]
    if ended.peak_force_n:
        lines.append(f"largest force: {ended.peak_force_n:.2f} N")
    lines.append(f"recorded: {folder / 'log.csv'} (rows: {ended.rows})")
    if ended.timing:
        lines += _table(ended.timing, rig)
    return "\n".join(lines)


def summary(ended: Ended, repetitions: int) -> str:
    """The same in one line."""
    presses = f"{ended.repetitions_done} of {repetitions} presses, {ended.time_s:.1f} s"
    if ended.how == "completed":
        return f"completed: {presses}"
    where = f"{ended.phase} of press {ended.repetition}" if ended.repetition else ended.phase
    why = "" if ended.how == "stopped" else f" ({ended.why})"
    return f"{ended.how}: {ended.cause} in {where}{why}; {presses}"


def _table(timing: LoopTiming, rig: RigSettings) -> list[str]:
    errors_ms = [1e3 * value for value in (timing.median_s, timing.p99_s, timing.p999_s, timing.largest_s)]
    return [
        f"{'control loop':<22}{'turns':>8}{'median':>9}{'99 %':>9}{'99.9 %':>9}{'largest':>9}{'overruns':>10}",
        f"{f'off {1e3 * rig.period_s:g} ms by, ms':<22}{timing.turns:>8}"
        + "".join(f"{value:>9.3f}" for value in errors_ms)
        + f"{timing.overruns:>10}",
    ]
