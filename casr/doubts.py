"""What makes a score one that somebody must look at before it counts."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from casr.contact_area.library_front import FREE_MISFIT
from casr.scored import Score

_Array = NDArray[np.float64]

STILL_SHARE = 0.25  # of the rise of the force; over it a contact moves its pins by a good part of their way
STILL_PX, STILL_OF_ALL = 0.02, 0.01  # less motion than this, and than this part of the farthest, is none
BACK = 0.3  # of the farthest motion of the press; more means that the frames go back


def doubts_on_score(score: Score) -> tuple[str, ...]:
    """Reasons to check a press that its numbers give; empty where there are none."""
    found = []
    known, unit = score.area[np.isfinite(score.area)], score.area_unit.replace("2", "²")
    if known.size and known[-1] < known[0]:
        found.append(
            f"the contact area shrank, from {known[0]:.4g} to {known[-1]:.4g} {unit}: do the frames run backwards?"
        )
    front = score.front
    # without a camera the dome's place is a guess, and a misfit says nothing of the press
    if (
        score.settings.quantity == "front"
        and score.area_unit == "mm2"
        and not score.front_doubt
        and front.off_library > FREE_MISFIT
    ):
        found.append(
            f"{front.off_library:.0%} of the motion of the pins is left over by every dome of the library, "
            f"{FREE_MISFIT:.0%} would be usual: another sensor (pin_length_mm, --domes), or not one contact"
        )
    rate = score.rate
    if rate is not None and rate.scatter_low is not None and rate.scatter_high is not None:
        low, high = rate.scatter_low, rate.scatter_high
        if low <= 0 <= high:
            found.append(f"by the scatter of the areas alone the spread rate may be 0: {low:.4g} to {high:.4g}")
    return tuple(found)


def doubts_on_motion(frames: NDArray[np.intp], force_n: ArrayLike, moved_px: ArrayLike) -> tuple[str, ...]:
    """Reasons to check a press whose pins do not go on while its force rises.

    Parameters
    ----------
    frames : (T,) indices of the loading. force_n : (T,) N. moved_px : (T,) mean distance of the pins from rest.
    """
    force, moved = (np.asarray(values, dtype=np.float64) for values in (force_n, moved_px))
    known = np.isfinite(force) & np.isfinite(moved)
    frames, force, moved = frames[known], force[known], moved[known]
    if frames.size < 3:
        return ()
    return (*_still(frames, force, moved), *_back(frames, force, moved))


def _still(frames: NDArray[np.intp], force_n: _Array, moved_px: _Array) -> tuple[str, ...]:
    """The longest stretch without motion over which the force rises by a good part of all its rise."""
    least_n = STILL_SHARE * float(force_n.max() - force_n.min())
    room_px = max(STILL_PX, STILL_OF_ALL * float(moved_px.max()))
    best = (0, 0)
    start = 0
    for end in range(frames.size):
        while float(np.ptp(moved_px[start : end + 1])) > room_px:
            start += 1
        if end - start > best[1] - best[0]:
            best = (start, end)
    a, b = best
    if not (b > a and force_n[b] - force_n[a] >= least_n > 0):
        return ()
    return (
        f"the pins stand still from frame {frames[a]} to {frames[b]} while the force goes from {force_n[a]:.2f} to "
        f"{force_n[b]:.2f} N: did the camera stop?",
    )


def _back(frames: NDArray[np.intp], force_n: _Array, moved_px: _Array) -> tuple[str, ...]:
    """The largest way back towards rest while the force does not fall."""
    best, found = BACK * float(moved_px.max()), ""
    top = 0
    for k in range(frames.size):
        if moved_px[k] >= moved_px[top]:
            top = k
        elif force_n[k] > force_n[top] and moved_px[top] - moved_px[k] > best:
            best = float(moved_px[top] - moved_px[k])
            found = (
                f"the pins go back by {best:.1f} px from frame {frames[top]} to {frames[k]} while the force goes from "
                f"{force_n[top]:.2f} to {force_n[k]:.2f} N: do the frames run backwards, or twice?"
            )
    return (found,) if found else ()


def note_on_repeats(frames: NDArray[np.intp], same: NDArray[np.bool_]) -> tuple[str, ...]:
    """Frames (T,) of the loading that are, to the last bit, the one before."""
    count = int(same.sum())
    if not count:
        return ()
    named = ", ".join(map(str, frames[same][:5].tolist())) + ", ..." * (count > 5)
    return (f"{count} of {frames.size} frames repeat the one before to the last bit: {named}",)
