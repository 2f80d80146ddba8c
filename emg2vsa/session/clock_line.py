"""The line of a device's clock through the arrivals of its samples.

Of all lines below the arrivals the one with the smallest sum of distances is taken: it is that edge of the convex hull
which lies below the mean (Moon, Skelly and Towsley, INFOCOM 1999). A stamp of the device itself may be early as well as
late. For these the line goes through the middle: medians of 0.1 s, and the median of the slopes between them (Theil,
1950; Sen, JASA 1968).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from emg2vsa.arrays import Floats

CRYSTAL = 1e-4
"Error of a stated rate that needs no telling; a measured rate counts as far as it is known better."
PERIODIC, WHOLE = 0.01, 0.02
"""A slower rate that is off by more has whole samples in a device's frame, within this; otherwise it is frames that are
lost evenly. Where fewer are, the steps show."""
LATE_S = 0.008
"Arrivals so far above the line are late: a busy computer, or samples that were lost (a Trigno frame is 13.5 ms)."
STEADY, STEPS = 0.5, 3
"""A rate is steady where neither four fifths of the arrivals nor any span of them spread by more than this share of
what can be lost at once, over a time in which losses in place of it would have been so many."""
LOWER = 0.25
"Where samples were lost the line goes through this share of the earliest arrivals of each second."
SPANS = 8
"A device whose rate changes leaves the line in whole spans of the stream."


class ClockLine(NamedTuple):
    """Slopes are those beside the stated one, s a sample; likely : with what is known of crystals.

    above_s : typical distance of an arrival. se_s : of a sample's time. is_stated : the slope is that of the stated
    rate, within errors. is_even : no span of the stream leaves the line, and the rate can be a device's. is_steady :
    nor do the arrivals within a span.
    """

    slope: float
    likely: float
    slope_se: float
    above_s: float
    se_s: float
    is_stated: bool
    is_steady: bool
    is_even: bool


class LineFitter(NamedTuple):
    """How lines are laid for a stream. quantum : samples that can be lost at once. stamped : times are the device's."""

    fs_hz: float
    quantum: int
    stamped: bool

    def through(self, x: Floats, y: Floats, *, amid: bool) -> ClockLine:
        """The line below all places (x ascending) and arrivals (Moon, Skelly and Towsley 1999), or amid them (Theil
        1950, Sen 1968)."""
        nominal = 1 / self.fs_hz
        z = y - nominal * x
        slope = _slope_amid(x, z) if amid else _slope_below(x, z)
        above = z - slope * x
        above -= self.level(above, amid=amid)
        above_s = float(np.median(np.abs(above)))
        slope_se = above_s / (math.sqrt(len(x)) * float(x.std()))
        off_s = max(abs(self.level(each, amid=amid)) for each in np.array_split(above, SPANS) if len(each))
        se_s = math.hypot(2 * above_s / math.sqrt(len(x)) if self.stamped else above_s, off_s)
        believed = CRYSTAL * nominal
        is_stated = abs(slope) <= 4 * math.hypot(believed, slope_se)
        likely = slope * believed**2 / (believed**2 + slope_se**2) if is_stated else slope
        low_s, high_s = np.quantile(above, (0.1, 0.9)).tolist()
        frame_s = self.quantum * nominal
        many = abs(slope) * (x[-1] - x[0]) > STEPS * frame_s
        steps_s = STEADY * max(frame_s, LATE_S)
        is_even = off_s < steps_s
        if self.quantum > 1 and abs(slope) > PERIODIC * nominal:
            in_frame = self.quantum / (1 + slope / nominal)
            is_even &= abs(in_frame - round(in_frame)) < WHOLE + 4 * in_frame * slope_se / nominal
        is_steady = many and is_even and high_s - low_s < steps_s
        return ClockLine(slope, likely, slope_se, above_s, se_s, is_stated, is_steady, is_even)

    def level(self, levels: Floats, *, amid: bool) -> float:
        """Level of the line, s, from the levels of its points (n,). Stamps are early and late; where samples were
        lost few arrivals are misplaced, and seem early.
        """
        return float(np.quantile(levels, 0.5 if self.stamped else LOWER if amid else 0.0))


def _slope_below(x: Floats, z: Floats) -> float:
    """Slope of that line below all points (x ascending) which has the smallest sum of distances to them."""
    hull: list[int] = []
    for point in range(len(x)):
        while len(hull) > 1:
            a, b = hull[-2:]
            if (z[b] - z[a]) * (x[point] - x[a]) < (z[point] - z[a]) * (x[b] - x[a]):
                break
            hull.pop()
        hull.append(point)
    right = max(1, int(np.searchsorted(x[hull], x.mean())))
    a, b = hull[right - 1], hull[right]
    return float((z[b] - z[a]) / (x[b] - x[a]))


def _slope_amid(x: Floats, z: Floats) -> float:
    """Median of the slopes between points that lie half the stream or more apart: few outliers do not move it."""
    half = len(x) // 2
    return float(np.median((z[half:, None] - z[None, :half]) / (x[half:, None] - x[None, :half])))
