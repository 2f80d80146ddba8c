"""The static frame before contact, from frames as they come in."""

from __future__ import annotations

from array import array
from collections import deque
from typing import Any

import numpy as np
from numpy.typing import NDArray

from casr.errors import FramesError
from casr.frames import loading_phase
from casr.images import Grey, as_grey

RECENT_FRAMES = 64
LOOKS = 64
"""A long rest is looked at anew each time it has grown by this part: of a million frames, some hundred times."""
Kept = tuple[int, Grey]


class RestFrame:
    """Knows the frame that ``loading_phase`` would take for the static one if contact came next.

    That choice looks at the forces of all frames at rest, so it may fall back on an earlier frame. Kept are the images
    of the last 64 frames at rest, and the one that was the choice up to 32 frames ago, or in a long rest up to a 64th
    of its frames ago.

    Parameters
    ----------
    start_n : force of first contact, N.
    """

    def __init__(self, start_n: float) -> None:
        self._start_n = start_n
        self._force_n = array("d")
        self._recent: deque[Kept] = deque(maxlen=RECENT_FRAMES)
        self._earlier: Kept | None = None
        self._look_at = RECENT_FRAMES // 2

    def take(self, image: NDArray[Any], force_n: float, zero_n: float = 0.0) -> None:
        """Take a frame out of contact and its force, N. zero_n : what counts as 0 N, by the forces so far."""
        # a camera may write its next frame into the same memory
        self._recent.append((len(self._force_n), as_grey(image).copy()))
        self._force_n.append(force_n)
        if (n := len(self._force_n)) == self._look_at:
            self._earlier = self._choice(zero_n)
            self._look_at = n + max(RECENT_FRAMES // 2, n // LOOKS)

    def image(self, zero_n: float = 0.0) -> Grey:
        """The static frame if contact comes now. Raises FramesError when no frame came before contact.

        zero_n : what the sensor reads at rest, N.
        """
        if not self._recent:
            raise FramesError(
                "stream",
                wanted="a static frame before contact",
                found="a first frame in contact",
                do="Start before the touch, or raise force_start_n.",
            )
        return self._choice(zero_n)[1]

    def _choice(self, zero_n: float) -> Kept:
        contact_n = (self._start_n, 2 * self._start_n)
        chosen = loading_phase(np.append(np.array(self._force_n) - zero_n, contact_n), start_n=self._start_n).rest
        kept = [self._earlier] if self._earlier else []
        # the frame itself, or the last one kept from before it
        return max((each for each in (*kept, *self._recent) if each[0] <= chosen), default=self._recent[0], key=_number)


def _number(kept: Kept) -> int:
    return kept[0]
