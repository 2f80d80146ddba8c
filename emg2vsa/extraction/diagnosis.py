"""Of all that was told of a recording, the one most likely cause, and what to do about it.

A recording that goes wrong says so in many ways: an electrode that dries fades, presses seem to lag by different times,
fits are uncertain. ``REMEDIES`` ranks what is told, causes before what follows from them. The most likely cause is the
first by that rank of what explains the presses that are lost; a remark on the recording explains all of them.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

from emg2vsa.extraction.reasons import by_hand, merged, put_aside
from emg2vsa.extraction.remedies import REMEDIES, known, remedies_of

EXPLAINS = 0.5
"A cause explains at least so much of the presses that the one which explains most does."


class Cause(NamedTuple):
    """``text``: what was found, of all presses that say so. ``do``: the remedy. ``explains``: so many presses."""

    text: str
    do: str
    explains: int


def ranked(remarks: Iterable[str], presses: Iterable[tuple[str, str]]) -> tuple[Cause, ...]:
    """The causes of what was told of one recording, the most likely first; none where no remedy is known.

    remarks : on the recording. presses : (verdict, reasons joined by "; ") of each, "" where there is none. Presses
    that are ``ok`` count only where all are, and those that a person has judged not at all.
    """
    told = [(verdict, reasons) for verdict, reasons in presses if not (by_hand(reasons) or put_aside(reasons))]
    counted = [reasons for verdict, reasons in told if verdict != "ok"] or [reasons for _, reasons in told]
    texts: dict[int, list[str]] = {}
    explains: dict[int, int] = {}
    for remark in remarks:
        for rank, text in _ranks(remark):
            texts.setdefault(rank, []).append(text)
            explains[rank] = max(len(counted), 1)
    for reasons in counted:
        for rank, text in dict(reversed(list(_ranks(reasons)))).items():
            texts.setdefault(rank, []).append(text)
            explains[rank] = min(explains.get(rank, 0) + 1, len(counted))
    most = max(explains.values(), default=0)
    order = sorted(explains, key=lambda rank: (explains[rank] < EXPLAINS * most, rank))
    return tuple(Cause(merged(texts[rank]), REMEDIES[rank].do, explains[rank]) for rank in order)


def _ranks(line: str) -> list[tuple[int, str]]:
    """The known reasons of a line that something can be done about, each with its place in ``REMEDIES``."""
    found = ((known(text), text, do) for text, do in remedies_of(line))
    return [(rank, text) for rank, text, do in found if do and rank is not None]
