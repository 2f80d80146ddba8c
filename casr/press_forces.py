"""The forces of a press as they are scored: spikes left out, frames shifted to the force, the resting level off."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from casr.errors import FramesError
from casr.frames import (
    CameraLag,
    ForceZero,
    FrameSequence,
    LoadingPhase,
    camera_lag,
    check_newtons,
    force_zero,
    loading_phase,
    note_on_spikes,
    notes_on_zero,
    spikes,
)
from casr.pins import PinTracker
from casr.scored import ScoreSettings

LEAD_FRAMES = 4  # before the rest frame: where frames are early, it is touched
MOST_BEFORE = 40  # between the rest frame and contact; a rise that takes longer tells no lag
AFTER_FRAMES = 20
KEPT_FRAMES = 64
"Around first contact, that a lag is told by."


@dataclass(frozen=True, eq=False)
class PressForces:
    """Forces of the frames of a press.

    force_n : (T,) N, NaN where not known. zero : of the sensor; None where not determined. lag_s : taken off the times
    of the frames. notes : what was done.
    """

    force_n: NDArray[np.float64]
    zero: ForceZero | None
    lag_s: float
    notes: tuple[str, ...]


def press_forces(sequence: FrameSequence, settings: ScoreSettings) -> PressForces:
    """Forces of a sequence that has some.

    FramesError : not newtons; a lag is to be corrected, and the log has no times, or it is not determined.
    """
    forces = shifted(sequence, settings, settings.camera_lag_s or 0.0)
    if not settings.correct_lag:
        return forces
    lag = _lag_looked_for(sequence, forces, settings)
    if lag is None or lag.lag_s is None:
        raise FramesError(
            "camera lag", wanted="a lag that the pins tell (correct_lag, --correct-lag)",
            found="a force log without times" if lag is None else f"none: {lag.why}",
            do="Give it (camera_lag_s, --camera-lag), or score without.",
        )  # fmt: skip
    return shifted(sequence, settings, lag.lag_s)


def frames_before(phase: LoadingPhase, sequence: FrameSequence) -> list[int]:
    """The rest frame; where the log has times also those around it up to contact, which tell the camera's lag."""
    rest, first = phase.rest, int(phase.frames[0])
    if sequence.readings is None:
        return [rest]
    return [*range(max(rest - LEAD_FRAMES, 0), rest + 1), *range(max(rest + 1, first - MOST_BEFORE), first)]


def pins_before(
    sequence: FrameSequence, phase: LoadingPhase, rest: Callable[[NDArray[np.generic]], PinTracker]
) -> tuple[list[int], list[NDArray[np.float64]]]:
    """``frames_before``, each decoded once in their order, and (N, 2) places of the pins at rest in each.

    rest : takes the rest frame, and gives what follows its pins.
    """
    frames = frames_before(phase, sequence)
    earlier = [sequence[index] for index in frames if index < phase.rest]
    tracker = rest(sequence[phase.rest])
    pins_px = [*map(tracker.step, earlier), tracker.first_px]
    return frames, [*pins_px, *(tracker.step(sequence[index]) for index in frames if index > phase.rest)]


def lag_of(
    sequence: FrameSequence,
    forces: PressForces,
    frames: Sequence[int],
    pins_px: Sequence[NDArray[np.float64]],
    start_n: float,
) -> CameraLag | None:
    """Lag of the camera by the motion of the pins (N, 2) in frames since before contact; None without times in the
    log."""
    if sequence.readings is None:
        return None
    kept = np.array(frames[:KEPT_FRAMES]), np.array(pins_px[:KEPT_FRAMES])
    zero_n = forces.zero.level_n if forces.zero else 0.0
    lag = camera_lag(*kept, sequence.readings, zero_n=zero_n, start_n=start_n)
    return replace(lag, corrected_s=forces.lag_s)


def notes_on_lag(lag: CameraLag | None) -> tuple[str, ...]:
    """What a reader should know of a lag that is still there."""
    if lag is None or not lag.doubtful or lag.remaining_s is None or lag.sd_s is None:
        return ()
    seen = _seen(lag.remaining_s, lag.sd_s)
    return (f"{seen}: more than half a frame; is the camera's time that of the force? --correct-lag takes it off",)


def note_on_shift(lag: CameraLag) -> str:
    """What a reader should know of a lag that was taken off unasked."""
    assert lag.lag_s is not None
    assert lag.sd_s is not None
    return f"{_seen(lag.lag_s, lag.sd_s)}: taken off the times of the frames; --camera-lag 0 leaves them"


def _seen(lag_s: float, sd_s: float) -> str:
    when = "after" if lag_s > 0 else "before"
    return f"the pins begin to move {1e3 * abs(lag_s):.0f} ms {when} the force (standard error {1e3 * sd_s:.0f} ms)"


def shifted(sequence: FrameSequence, settings: ScoreSettings, lag_s: float) -> PressForces:
    """Forces of a sequence whose frames were taken ``lag_s`` (s) before their times; FramesError as ``press_forces``,
    and where its forces have no times."""
    assert sequence.force_n is not None
    force_n = sequence.force_n
    if lag_s:
        if sequence.readings is None:
            raise FramesError(
                "camera lag", wanted="a force log with time_s, and forces at exposure (--force-rule exposure)",
                found="forces without times", do="Add the column, or score without --camera-lag.",
            )  # fmt: skip
        force_n = sequence.readings.at_frames(lag_s)
    return replace(_tared(force_n.tobytes(), settings.force_start_n, settings.tare), lag_s=lag_s)


@lru_cache(maxsize=16)  # every algorithm that scores a press asks for its forces
def _tared(as_bytes: bytes, start_n: float, tare: bool) -> PressForces:
    force_n = np.frombuffer(as_bytes)
    wild = spikes(force_n)
    notes = note_on_spikes(wild, force_n, f"of {wild.size} frames have a force that")
    force_n = np.where(wild, np.nan, force_n)
    check_newtons(force_n, "force")
    zero = force_zero(force_n, start_n)
    if zero is not None:
        zero = replace(zero, taken_off=tare)
    if tare:
        notes += notes_on_zero(zero, start_n)
        force_n = force_n - (zero.level_n if zero else 0.0)
    force_n.flags.writeable = False
    return PressForces(force_n, zero, 0.0, notes)


def _lag_looked_for(sequence: FrameSequence, forces: PressForces, settings: ScoreSettings) -> CameraLag | None:
    """The lag before anything is scored, from the frames around first contact."""
    if sequence.readings is None:
        return None
    phase = loading_phase(forces.force_n, start_n=settings.force_start_n, stop_n=settings.force_stop_n)
    tracker = PinTracker(settings.flow.pins)

    def rest(image: NDArray[np.generic]) -> PinTracker:
        tracker.start(image)
        return tracker

    frames, pins_px = pins_before(sequence, phase, rest)
    loading = phase.frames[:AFTER_FRAMES].tolist()
    pins_px += [tracker.step(sequence[index]) for index in loading]
    return lag_of(sequence, forces, [*frames, *loading], pins_px, settings.force_start_n)
