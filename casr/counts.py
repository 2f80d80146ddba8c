"""What a piece of work did, counted where it is done while somebody asks: files read, frames decoded, fits made.

Nobody asks by default; ``count`` then looks at one empty list. Counting changes no result. It is for one thread: work
in a child process is counted by the process that asks for it.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

COUNTED = {
    "files read": "recordings opened, and stored results read",
    "bytes read": "size of these files",
    "samples decoded": "of recorded channels, those asked for",
    "samples conditioned": "through the filters, one count for each channel, with the support of the filters",
    "fits": "curves fitted to one row of points",
    "frames in folder": "frames of the presses that were opened",
    "frames decoded": "of these, read from disk and decoded",
    "frames decoded again": "of these, another time",
    "frames scored": "frames that entered a score",
    "pixels weighed": "pixels that entered a search for pins, the place of a pin, or a field of flow",
}
"""Each name that is counted, and what it means; reports list them in this order."""

_open: list[dict[str, int]] = []


def count(what: str, n: int = 1) -> None:
    """Add ``n`` to the count of ``what``, a key of ``COUNTED``, of everybody who asks."""
    for counts in _open:
        counts[what] = counts.get(what, 0) + n


@contextmanager
def counting() -> Iterator[dict[str, int]]:
    """Counts of what is done inside, by name; what was not done has no name."""
    counts: dict[str, int] = {}
    _open.append(counts)
    try:
        yield counts
    finally:
        _open[:] = [each for each in _open if each is not counts]
