"""What the force sensor reads at rest: found before the first contact and taken off all readings."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from casr.median import median

REST_BAND = 0.1  # of the force of first contact: readings this close together are one resting level
FEWEST_AT_REST = 3
RECENT = 200  # frames at rest that count: a sensor's zero drifts
MEDIAN_ERROR = float(np.sqrt(np.pi / 2))  # standard error of a median over that of the mean

_Array = NDArray[np.float64]


@dataclass(frozen=True)
class ForceZero:
    """What the force sensor reads when nothing touches.

    Parameters
    ----------
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

    Parameters
    ----------
    start_n : force of first contact, N.

    Attributes
    ----------
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
        """Whether the next frame, of this force as logged, is in contact. NaN is not."""
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
    levels = np.sort(force_n)
    inside = np.searchsorted(levels, levels + REST_BAND * start_n, side="right") - np.arange(levels.size)
    lowest = int(np.argmax(inside))
    resting = force_n[(force_n >= levels[lowest]) & (force_n <= levels[lowest + inside[lowest] - 1])]
    middle = np.sort(resting)[(resting.size - 1) // 2]
    resting = resting[: max(np.flatnonzero(resting <= middle)[-1] + 1, FEWEST_AT_REST)]
    if resting.size < FEWEST_AT_REST:
        return None
    error = MEDIAN_ERROR * float(resting.std(ddof=1)) / np.sqrt(resting.size)
    return ForceZero(float(median(resting)), float(error), int(resting.size))


def force_zero(force_n: ArrayLike, start_n: float) -> ForceZero | None:
    """The zero of a whole recording of forces (T,), NaN where not known; None where its rest does not tell it."""
    rest = RestingForce(start_n)
    for reading in np.asarray(force_n, dtype=np.float64).ravel().tolist():
        if rest.touches(reading):
            break
    return rest.zero


def notes_on_zero(zero: ForceZero | None, start_n: float) -> tuple[str, ...]:
    """What a reader of tared forces should know of their zero."""
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
