"""What the numbers on records tell: lost, late and repeated ones."""

from __future__ import annotations

REMEMBERED = 4096
"Lost numbers that may still come late; further back, late counts as repeated."

_WRAP = 2**32


def steps(before: int, after: int) -> int:
    """From one 32-bit number to another, forwards or backwards, whichever is shorter."""
    return (after - before + _WRAP // 2) % _WRAP - _WRAP // 2


class SequenceCount:
    """Counts over one stream whose records are numbered 1, 2, ...

    lost : numbers that never came. late : came after a higher one. repeated : came more than once.
    """

    def __init__(self) -> None:
        self.lost = self.late = self.repeated = 0
        self._newest = 0
        self._missing: dict[int, None] = {}

    def arrived(self, number: int) -> int | None:
        """How many are missing between the newest so far and this one; None when this one is not newer."""
        ahead = steps(self._newest, number)
        if ahead > 0:
            self._miss(number, ahead - 1)
            self._newest = number
            return ahead - 1
        if number in self._missing:
            del self._missing[number]
            self.lost, self.late = self.lost - 1, self.late + 1
        else:
            self.repeated += 1
        return None

    def _miss(self, number: int, count: int) -> None:
        self.lost += count
        for back in range(min(count, REMEMBERED), 0, -1):
            self._missing[(number - back) % _WRAP] = None
        while len(self._missing) > REMEMBERED:
            del self._missing[next(iter(self._missing))]
