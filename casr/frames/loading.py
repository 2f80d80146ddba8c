"""The parts of a press by its force: the resting level before contact, the static frame, the loading up to F_max."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from casr.errors import FramesError, NoContactError, SettingError
from casr.median import median

REST_BAND = 0.1  # of the force of first contact: readings this close together are one resting level
FEWEST_AT_REST = 3
RECENT = 200  # frames at rest that count: a sensor's zero drifts
MEDIAN_ERROR = float(np.sqrt(np.pi / 2))  # standard error of a median over that of the mean

_Array = NDArray[np.float64]


@dataclass(frozen=True)
class ForceZero:
    """Reading of the force sensor when nothing touches.

    level_n : N, the median of ``n`` frames at rest. sd_n : its standard error, N.
    taken_off : whether the forces are without it.
    """

    level_n: float
    sd_n: float
    n: int
    taken_off: bool = True


class RestingForce:
    """Judges frame by frame whether the sensor touches, and from the first contact on knows its zero.

    Until then the zero is that of the frames so far: of their densest band, 0.1 ``start_n`` wide, those up to the last
    at or below its median, so that the ramp up to contact is not in it. Three or more tell it; before, 0 N counts, or
    the first reading where that is half of ``start_n`` or more, as of a sensor that was never zeroed.

    start_n : force of first contact, N.

    Attributes:
    zero : None while it is not known.
    """

    def __init__(self, start_n: float) -> None:
        self.zero: ForceZero | None = None
        self._start_n = start_n
        self._rest_n: deque[float] = deque(maxlen=RECENT)
        self._touched = False

    @property
    def level_n(self) -> float:
        """What counts as 0 N now."""
        if self.zero is not None:
            return self.zero.level_n
        first_n = self._rest_n[0] if self._rest_n and not self._touched else 0.0
        return first_n if first_n >= self._start_n / 2 else 0.0

    def touches(self, force_n: float) -> bool:
        """Whether the next frame, of this force as logged, N, is in contact. NaN is not."""
        if np.isnan(force_n):
            return False
        if not self._touched and not self._rest_n and force_n >= self._start_n:
            self._rest_n.append(force_n)
            return False
        contact = force_n - self.level_n >= self._start_n
        if contact:
            self._touched = True
        elif not self._touched:
            self._rest_n.append(force_n)
            self.zero = resting_level(np.array(self._rest_n), self._start_n)
        return contact


def resting_level(force_n: _Array, start_n: float) -> ForceZero | None:
    """Level of the forces (n,) before a contact, N, as `RestingForce` has it; None where too few tell it."""
    lowest, middle, highest = _resting_band(force_n, start_n)
    resting = force_n[(force_n >= lowest) & (force_n <= highest)]
    resting = resting[: max(np.flatnonzero(resting <= middle)[-1] + 1, FEWEST_AT_REST)]
    if resting.size < FEWEST_AT_REST:
        return None
    error = MEDIAN_ERROR * float(resting.std(ddof=1)) / np.sqrt(resting.size)
    return ForceZero(float(median(resting)), float(error), int(resting.size))


def _resting_band(force_n: _Array, start_n: float) -> _Array:
    """(3,) lowest, middle and highest of those of the forces (n,) in the densest band of ``REST_BAND``, the lowest."""
    levels = np.sort(force_n)
    inside = np.searchsorted(levels, levels + REST_BAND * start_n, side="right") - np.arange(levels.size)
    first = int(np.argmax(inside))
    last = first + int(inside[first]) - 1
    # the lower middle one, so that at least one frame is at or below it
    return levels[[first, (first + last) // 2, last]]


def force_zero(force_n: ArrayLike, start_n: float) -> ForceZero | None:
    """The zero of a whole recording of forces (T,), N, NaN where not known; None where its rest does not tell it.

    start_n : force of first contact, N.
    """
    rest = RestingForce(start_n)
    for reading in np.asarray(force_n, dtype=np.float64).ravel().tolist():
        if rest.touches(reading):
            break
    return rest.zero


def notes_on_zero(zero: ForceZero | None, start_n: float) -> tuple[str, ...]:
    """What a reader of tared forces should know of their zero. start_n : force of first contact, N."""
    if zero is None:
        return (
            f"the force's zero is not determined and nothing is taken off: fewer than {FEWEST_AT_REST} frames at one "
            "resting level before contact",
        )
    if not zero.taken_off or abs(zero.level_n) <= REST_BAND * start_n:
        return ()
    said = f"the force rests at {zero.level_n:.3g} N (standard error {zero.sd_n:.2g} N), which is taken off"
    touched = zero.level_n >= start_n
    return (f"{said}; is the sensor free there, and only its zero off?" if touched else said,)


@dataclass(frozen=True)
class LoadingPhase:
    """Frames of one loading.

    rest : index of the static frame before contact, Algorithm 1's ``file.TIFF[0]``.
    frames : (n,) increasing indices from first contact to the end, inclusive. notes : what was skipped or chosen.
    """

    rest: int
    frames: NDArray[np.intp]
    notes: tuple[str, ...] = ()


NEARLY = 0.8
"""Share of the force to stop at: at 16 N/s and 20 frames a second the last frame of a press lies up to 0.8 N below its
peak.
"""


def loading_phase(force_n: ArrayLike, *, start_n: float = 0.5, stop_n: float | None = None) -> LoadingPhase:
    """The part of a press that CASR is computed on: from first contact to the largest force, never the unloading.

    A press is an unbroken stretch of frames at or above ``start_n`` that reaches ``stop_n``, or half of the largest
    force when there is none; shorter touches are chatter. The first press counts. Loading starts at its first frame
    and ends at the first frame that reaches ``stop_n``, or at its largest force; a press that turns back at ``stop_n``
    between two frames counts from ``NEARLY`` of it on, where none reaches it. Frames without a force are skipped.

    The rest frame comes before it. The resting band, 0.1 ``start_n`` wide, is the one
    that holds most of these frames (the lowest on a tie); the last frame at or below the median of the band is
    taken. So neither the ramp up to ``start_n``, where the skin is touched already (at a tenth of the force a
    contact has half of its radius), nor a pull of the leaving skin counts as static while a frame at rest exists.

    force_n : (T,) force of each frame, N; NaN where not known. start_n : force of first contact, N; 0.5 in the paper.
    stop_n : force at which loading ends, N; None for the largest. NoContactError : the force never reaches ``start_n``.
    FramesError : no force at all; ``stop_n`` is not reached; no frame before contact; loading within a single frame.
    SettingError : ``start_n`` not above 0, ``stop_n`` not above ``start_n``.
    """
    _check_forces_asked(start_n, stop_n)
    force = np.asarray(force_n, dtype=np.float64).ravel()
    known = np.flatnonzero(np.isfinite(force))
    load = force[known]
    presses = _presses(load, start_n, stop_n)
    first, last = presses[0]
    reached = load[first:last] >= (np.inf if stop_n is None else stop_n)
    end = first + int(np.argmax(reached if reached.any() else load[first:last]))
    rest = _rest_frame(known[:first], load[:first], start_n)
    frames = known[first : end + 1]
    if len(frames) < 2:
        raise FramesError(
            "loading phase", wanted="at least two frames of loading",
            found=f"the force goes from below {start_n:g} N to its end within one frame, {frames[0]}",
            do="Load more slowly, record more frames a second, or lower start_n (--start-n).",
        )  # fmt: skip
    many = [f"{len(presses)} presses in the sequence; the first is used"] if len(presses) > 1 else []
    return LoadingPhase(rest, frames, (*many, *_notes(force, rest, frames, start_n)))


def _check_forces_asked(start_n: float, stop_n: float | None) -> None:
    if not (np.isfinite(start_n) and start_n > 0):
        raise SettingError("start_n", wanted="a force above 0 N", found=repr(start_n), do="The paper uses 0.5.")
    if stop_n is not None and not (np.isfinite(stop_n) and stop_n > start_n):
        raise SettingError(
            "stop_n", wanted=f"a force above start_n, {start_n:g} N", found=repr(stop_n), do="Raise it or leave it out."
        )


def _presses(load: NDArray[np.float64], start_n: float, stop_n: float | None) -> list[tuple[int, int]]:
    """[first, past the last) of every press, in positions of ``load``."""
    if load.size == 0:
        raise FramesError(
            "force", wanted="a force for some frames", found="none", do="Check the frame indices of the force log."
        )
    peak = float(load.max())
    if peak < start_n:
        raise NoContactError(
            "force", wanted=f"contact, a force of {start_n:g} N or more", found=f"at most {peak:.3g} N",
            do="Lower start_n (--start-n), or check the sign and unit of the force log.",
        )  # fmt: skip
    if stop_n is not None and peak < NEARLY * stop_n:
        raise FramesError(
            "force", wanted=f"a load up to stop_n (--stop-n), {stop_n:g} N, or {NEARLY:.0%} of it",
            found=f"at most {peak:.3g} N",
            do="Press again, lower it, or leave it out to end at the largest force.",
        )  # fmt: skip
    edges = np.flatnonzero(np.diff(load >= start_n, prepend=False, append=False))
    reached = max(start_n, peak / 2)
    if stop_n is not None:
        reached = stop_n if peak >= stop_n else NEARLY * stop_n
    return [(a, b) for a, b in edges.reshape(-1, 2).tolist() if load[a:b].max() >= reached]


def _rest_frame(before: NDArray[np.intp], load: NDArray[np.float64], start_n: float) -> int:
    untouched = load < start_n
    before, load = before[untouched], load[untouched]
    if before.size == 0:
        raise FramesError(
            "loading phase", wanted=f"a static frame before contact, below {start_n:g} N",
            found="a recording that starts in contact",
            do="Start recording before the touch, or raise start_n (--start-n).",
        )  # fmt: skip
    lowest, middle, _ = _resting_band(load, start_n)
    return int(before[(load >= lowest) & (load <= middle)][-1])


def _notes(force: NDArray[np.float64], rest: int, frames: NDArray[np.intp], start_n: float) -> list[str]:
    notes = []
    missing = int(frames[-1] - frames[0] + 1 - len(frames))
    if missing:
        notes.append(f"{missing} frames of the loading carry no force and are skipped")
    if abs(force[rest]) > 2 * REST_BAND * start_n:
        notes.append(f"the force rests at {force[rest]:.2g} N, not near zero: an offset, or frame {rest} is touched")
    steps = np.diff(force[frames])
    falling = int((steps < 0).sum())
    if falling:
        share = falling / len(steps)
        notes.append(
            f"the force falls in {falling} of {len(steps)} steps ({share:.0%}), at most by {-steps.min():.2g} N"
        )
    return notes
