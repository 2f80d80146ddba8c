"""Twenty frames a second out of what a camera gives, and how many are missing."""

from __future__ import annotations

EARLY = 0.1
"Part of a period by which a frame may be early."
SHORT = 0.2
"A gap this part of a period short of two periods still means that a frame is missing."
CATCH_UP = 0.25
"After a late frame the next is due at least this part of a period later."


class FramePace:
    """Chooses frames by their time.

    A camera at the wanted rate keeps all its frames, however its clock drifts; a faster one is thinned out to the
    wanted rate on average.

    Parameters
    ----------
    rate_hz : wanted frames a second.
    """

    def __init__(self, rate_hz: float) -> None:
        self._period_s = 1 / rate_hz
        self._taken_s: float | None = None
        self._due_s = 0.0

    def take(self, time_s: float) -> int | None:
        """How many frames are missing before the one of ``time_s``; None when that one is not due."""
        if self._taken_s is None:
            self._taken_s, self._due_s = time_s, time_s + self._period_s
            return 0
        if time_s < self._due_s - EARLY * self._period_s:
            return None
        missing = max(0, int((time_s - self._taken_s) / self._period_s + SHORT) - 1)
        next_s = max(self._due_s + self._period_s, time_s + CATCH_UP * self._period_s)
        self._taken_s, self._due_s = time_s, min(next_s, time_s + self._period_s)
        return missing
