"""The interval of a stiffness: by the errors of the mean profiles, and of both ends of mapping (7).

A share of the mapped range, (v - v_low) / (v_high - v_low), has the gradient (dv - (1 - share) dv_low -
share dv_high) / (v_high - v_low) in the coefficients (delta method). Which specimen and force have the smallest
activity is itself found from the data: every end whose difference from it is within its own interval could be that
end, and the interval of the stiffness is the union over these. At an end that none other rivals it has no width: there
the stiffness is the end of the range by definition.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from emg2vsa.arrays import Floats
from emg2vsa.profiles import MeanErrors


@dataclass(frozen=True)
class Activities:
    """v (K,), and the ``weights`` (K, S, 2) that the mean coefficients of the specimens have in them."""

    v: Floats
    weights: Floats

    def only(self, place: int) -> Activities:
        """The one there."""
        return Activities(self.v[[place]], self.weights[[place]])


def joined(parts: Sequence[Activities]) -> Activities:
    """All of them in a row."""
    return Activities(np.concatenate([p.v for p in parts]), np.concatenate([p.weights for p in parts]))


def share_interval(
    of: Sequence[Activities], lowest: Sequence[Activities], highest: Sequence[Activities], errors: MeanErrors
) -> Floats:
    """Low and high (2, K) share, 0 to 1, of activities any of which it could be, in a range with any of these ends.

    The mapping is equation (7) of the paper.
    """
    found = np.array([*_of_all(of, lowest, highest, errors)])
    return np.asarray(np.clip([found[:, 0].min(axis=0), found[:, 1].max(axis=0)], 0.0, 1.0))


def _of_all(
    of: Sequence[Activities], lowest: Sequence[Activities], highest: Sequence[Activities], errors: MeanErrors
) -> Iterator[tuple[Floats, Floats]]:
    for low in lowest:
        for high in highest:
            span = high.v - low.v
            for each in of if span > 0 else ():
                share = (each.v - low.v) / span
                part = share[:, None, None]
                half = errors.half_width((each.weights - (1 - part) * low.weights - part * high.weights) / span)
                yield share - half, share + half


def rivals(ends: Activities, sign: float, errors: MeanErrors) -> list[Activities]:
    """Those of ``ends`` that could be the largest (``sign`` 1) or the smallest (-1), that of the data first."""
    first = int(np.argmax(sign * ends.v))
    behind = np.abs(ends.v - ends.v[first])
    near = behind <= errors.half_width(ends.weights - ends.weights[first])
    near[first] = False
    return [ends.only(place) for place in (first, *np.flatnonzero(near).tolist())]
