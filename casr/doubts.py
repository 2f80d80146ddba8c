"""What makes a score one that somebody must look at before it counts, alone or beside the presses of its session."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from casr.scored import Score
from casr.spread.intervals import normal_quantile

Array = NDArray[np.float64]

FEWEST_OTHERS = 3
"Presses that one is compared with: the median of two is as wrong as either."
FEWEST_FRAMES = 4
LEAST_FORCE_RATIO = 1.5
"Least ratio of the highest to the lowest common force: below it hardly anything grows."
UNSHARED_SD = 0.05
"""SD of the logarithm of the ratio from press to press of one sensor: specimens of 1.1 to 7.6 N/mm differ by 0.1 in
finite elements, presses of one kind by 0.02 to 0.06; the error of dome, pin length and depth is shared."""
CHANCE = 0.05
"Chance that a press of a session is named although all presses are alike."
_MAD, _MEDIAN = 1.4826, 1.2533
"Standard deviation over the median of absolute deviations; standard error of a median over that of a mean."


@dataclass(frozen=True, eq=False)
class Stretch:
    """How the first contact's skin grew against the contact, over force, in one press.

    force_n, log_ratio : (T,) of the frames whose front is determined: ln of skin growth over front growth since the
    first of them. log_sd : standard error of its rise over all of them, without what all presses of a sensor share.
    """

    force_n: Array
    log_ratio: Array
    log_sd: float

    def between(self, low_n: float, high_n: float) -> float:
        """Rise of the logarithm between two forces, N, in a straight line from frame to frame by rising force."""
        low, high = np.interp([low_n, high_n], *self._by_force)
        return float(high - low)

    @cached_property
    def range_n(self) -> tuple[float, float]:
        """The least and the largest force, N."""
        return float(self.force_n.min()), float(self.force_n.max())

    @cached_property
    def _by_force(self) -> tuple[Array, Array]:
        order = np.argsort(self.force_n, kind="stable")
        return self.force_n[order], self.log_ratio[order]


def stretch_of(score: Score) -> Stretch | None:
    """None without forces, or where the front is not determined in four frames or more."""
    found = score.front_spread
    if found is None or score.force_n is None:
        return None
    skin = np.append(0.0, np.cumsum(score.log_growth))
    kept = score.front.determined & (score.force_n > 0)
    if kept.sum() < FEWEST_FRAMES:
        return None
    ratio = skin[kept] - np.log(score.front.area[kept])
    pins = score.front.parts["pins"][kept]
    return Stretch(score.force_n[kept], ratio - ratio[0], float(np.hypot(np.hypot(pins[0], pins[-1]), UNSHARED_SD)))


def unlike_others(stretches: Mapping[str, Stretch]) -> dict[str, str]:
    """Press to the reason to check it, for those whose ratio differs from the others' at the same forces.

    Each is compared with the median of at least three others, over the forces that it has in common with each of them;
    its difference is held against its own error and that of the median, at 5 % for all presses together.
    """
    limit = normal_quantile(1 - CHANCE / max(len(stretches), 1))
    found = {}
    pairs = _pairs(list(stretches.values()))
    for row, (name, own) in enumerate(stretches.items()):
        compared = np.array([pair for pair in pairs[row] if pair is not None])
        if len(compared) < FEWEST_OTHERS:
            continue
        apart = compared[:, 0] - compared[:, 1]
        apart_by = float(np.median(apart))
        scatter = _MAD * float(np.median(np.abs(apart - apart_by)))
        sd = float(np.hypot(own.log_sd, _MEDIAN * max(scatter, UNSHARED_SD) / np.sqrt(len(apart))))
        if abs(apart_by) > limit * sd:
            mine, theirs = np.exp(np.median(compared, axis=0))
            found[name] = (
                f"skin grew {mine:.2f} times as much as the contact, in the other presses {theirs:.2f} times at the "
                f"same forces, {abs(apart_by) / sd:.1f} standard errors apart: slip, other friction, or lost pins"
            )
    return found


def _pairs(stretches: list[Stretch]) -> list[list[tuple[float, float] | None]]:
    """For each press, its ``_pair`` with every other press, in their order."""
    pairs: list[list[tuple[float, float] | None]] = [[None] * len(stretches) for _ in stretches]
    for row, own in enumerate(stretches):
        for column, other in enumerate(stretches[:row]):
            pair = _pair(own, other)
            pairs[row][column], pairs[column][row] = pair, None if pair is None else pair[::-1]
    return pairs


def _pair(own: Stretch, other: Stretch) -> tuple[float, float] | None:
    """Rise of both over their common forces; None where these are too few."""
    low_n, high_n = max(own.range_n[0], other.range_n[0]), min(own.range_n[1], other.range_n[1])
    if high_n < LEAST_FORCE_RATIO * low_n:
        return None
    return own.between(low_n, high_n), other.between(low_n, high_n)


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
        and front.off_library > front.usual_misfit
    ):
        found.append(
            f"{front.off_library:.0%} of the motion of the pins is left over by every dome of the library, "
            f"{front.usual_misfit:.0%} would be usual: another sensor (pin_length_mm, --domes), or not one contact"
        )
    rate = score.rate
    if rate is not None and rate.scatter_low is not None and rate.scatter_high is not None:
        low, high = rate.scatter_low, rate.scatter_high
        if low <= 0 <= high:
            found.append(f"by the scatter of the areas alone the spread rate may be 0: {low:.4g} to {high:.4g}")
    return tuple(found)


def doubts_on_motion(frames: NDArray[np.intp], force_n: ArrayLike, moved_px: ArrayLike) -> tuple[str, ...]:
    """Reasons to check a press whose pins do not go on while its force rises.

    frames : (T,) indices of the loading. force_n : (T,) N. moved_px : (T,) mean distance of the pins from rest.
    """
    force, moved = (np.asarray(values, dtype=np.float64) for values in (force_n, moved_px))
    known = np.isfinite(force) & np.isfinite(moved)
    frames, force, moved = frames[known], force[known], moved[known]
    if frames.size < 3:
        return ()
    return (*_still(frames, force, moved), *_back(frames, force, moved))


def _still(frames: NDArray[np.intp], force_n: Array, moved_px: Array) -> tuple[str, ...]:
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


def _back(frames: NDArray[np.intp], force_n: Array, moved_px: Array) -> tuple[str, ...]:
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
