"""The loading phase of a press: the static frame before contact, and the frames from first contact to F_max."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from casr.errors import FramesError, NoContactError, SettingError
from casr.frames.tare import REST_BAND


@dataclass(frozen=True)
class LoadingPhase:
    """Frames of one loading.

    Parameters
    ----------
    rest : index of the static frame before contact, Algorithm 1's ``file.TIFF[0]``.
    frames : (n,) increasing indices from first contact to the end, inclusive.
    notes : what was skipped or chosen.
    """

    rest: int
    frames: NDArray[np.intp]
    notes: tuple[str, ...] = ()


def loading_phase(force_n: ArrayLike, *, start_n: float = 0.5, stop_n: float | None = None) -> LoadingPhase:
    """The part of a press that CASR is computed on: from first contact to the largest force, never the unloading.

    A press is an unbroken stretch of frames at or above ``start_n`` that reaches ``stop_n``, or half of the largest
    force when there is none; shorter touches are chatter. The first press counts. Loading starts at its first frame
    and ends at the first frame that reaches ``stop_n``, or at its largest force. Frames without a force are skipped.

    The rest frame comes before it. The resting band, 0.1 ``start_n`` wide, is the one
    that holds most of these frames (the lowest on a tie); the last frame at or below the median of the band is
    taken. So neither the ramp up to ``start_n``, where the skin is touched already (at a tenth of the force a
    contact has half of its radius), nor a pull of the leaving skin counts as static while a frame at rest exists.

    Parameters
    ----------
    force_n : (T,) force of each frame, N; NaN where not known.
    start_n : force of first contact, N; 0.5 in the paper.
    stop_n : force at which loading ends, N; None for the largest.

    Raises
    ------
    NoContactError : the force never reaches ``start_n``.
    FramesError : no force at all; ``stop_n`` is not reached; no frame before contact; loading within a single frame.
    SettingError : ``start_n`` not above 0, ``stop_n`` not above ``start_n``.
    """
    _check_forces_asked(start_n, stop_n)
    force = np.asarray(force_n, dtype=np.float64).ravel()
    known = np.flatnonzero(np.isfinite(force))
    load = force[known]
    presses = _presses(load, start_n, stop_n)
    first, last = presses[0]
    end = first + (np.argmax(load[first:last]) if stop_n is None else np.argmax(load[first:last] >= stop_n))
    rest = _rest_frame(known[:first], load[:first], start_n)
    frames = known[first : end + 1]
    if len(frames) < 2:
        raise FramesError(
            "loading phase",
            wanted="at least two frames of loading",
            found=f"the force goes from below {start_n:g} N to its end within one frame, {frames[0]}",
            do="Load more slowly, record more frames a second, or lower start_n (--start-n).",
        )
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
            "force",
            wanted=f"contact, a force of {start_n:g} N or more",
            found=f"at most {peak:.3g} N",
            do="Lower start_n (--start-n), or check the sign and unit of the force log.",
        )
    if stop_n is not None and peak < stop_n:
        raise FramesError(
            "force",
            wanted=f"a load up to stop_n (--stop-n), {stop_n:g} N",
            found=f"at most {peak:.3g} N",
            do="Lower it, or leave it out to end at the largest force.",
        )
    edges = np.flatnonzero(np.diff(load >= start_n, prepend=False, append=False))
    reached = stop_n if stop_n is not None else max(start_n, peak / 2)
    return [(a, b) for a, b in edges.reshape(-1, 2).tolist() if load[a:b].max() >= reached]


def _rest_frame(before: NDArray[np.intp], load: NDArray[np.float64], start_n: float) -> int:
    untouched = load < start_n
    before, load = before[untouched], load[untouched]
    if before.size == 0:
        raise FramesError(
            "loading phase",
            wanted=f"a static frame before contact, below {start_n:g} N",
            found="a recording that starts in contact",
            do="Start recording before the touch, or raise start_n (--start-n).",
        )
    levels = np.sort(load)
    band = REST_BAND * start_n
    inside = np.searchsorted(levels, levels + band, side="right") - np.arange(len(levels))
    lowest = int(np.argmax(inside))
    resting = levels[lowest : lowest + inside[lowest]]
    # the lower middle one, so that at least one frame is at or below it
    middle = resting[(len(resting) - 1) // 2]
    return int(before[(load >= resting[0]) & (load <= middle)][-1])


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
