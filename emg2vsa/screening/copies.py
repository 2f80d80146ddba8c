"""Recordings that are copies of each other: their presses fluctuate alike, which independent presses never do."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping

import numpy as np

from emg2vsa.arrays import Floats, Ints
from emg2vsa.screening import Verdict
from emg2vsa.signals.traits import Traits

Key = tuple[str, str]
"Participant and specimen."
Found = tuple[Key, str, str, float, Verdict]
"What was found: recording, cause, the sentence, the share of b, the verdict."

SAME = 0.97
"Correlation of the fluctuations of two presses that are one; independent presses of 32 points reach 0.8."
FORCES_SAME = 0.9
ALIKE, IN_ORDER = 0.65, 3
"... or so many presses, at least half, in the same order: force in another scale begins and ends presses elsewhere."
PAIRS_AT_ONCE, SINGLE = 1 << 24, 1e-5
"Pairs of presses in memory; how far their product in single precision is off at most."


def copies(traits: Mapping[Key, Traits]) -> Iterator[Found]:
    """Presses whose fluctuations are those of another recording's presses: nobody knows whose they are."""
    keys = [key for key, own in traits.items() if np.isfinite(own.fingerprints).all(axis=(1, 2)).any()]
    if not keys:
        return
    known = [own[np.isfinite(own).all(axis=(1, 2))] for own in (traits[key].fingerprints for key in keys)]
    rows = np.concatenate(known)
    of = np.repeat(np.arange(len(keys)), [len(own) for own in known])
    counts = np.bincount(of, minlength=len(keys))
    number = np.concatenate([np.arange(len(own)) for own in known])
    pairs: dict[tuple[int, int], set[int]] = {}
    alike: Counter[tuple[int, int, int]] = Counter()
    for mine, theirs in _alike(rows[:, 1], of):
        both = (_products(rows[:, 1], mine, theirs) > SAME) & (_products(rows[:, 0], mine, theirs) > FORCES_SAME)
        for one, other in ((mine, theirs), (theirs, mine)):
            ahead = number[other] - number[one]
            alike.update(zip(of[one].tolist(), of[other].tolist(), ahead.tolist(), strict=True))
            for i, j in zip(one[both].tolist(), other[both].tolist(), strict=True):
                pairs.setdefault((int(of[i]), int(of[j])), set()).add(i)
    same = {
        pair for pair, presses in pairs.items()
        if len(presses) >= max(2, 0.5 * counts[list(pair)].min()) and len(pairs.get(pair[::-1], ())) >= 2
    }  # fmt: skip
    for (own, twin, _), n in alike.items():
        if n >= max(IN_ORDER, 0.5 * counts[[own, twin]].min()):
            same.add((own, twin))
    for own, twin in sorted(same):
        yield keys[own], "copy", f"the same recording as {'/'.join(keys[twin])}", np.nan, "unreadable"


def _alike(rows: Floats, of: Ints) -> Iterator[tuple[Ints, Ints]]:
    """Pairs of rows of two recordings whose product is more than ALIKE, the earlier row first.

    Single precision finds the candidates, as a study of a thousand people has a thousand million pairs.
    """
    single = rows.astype(np.float32)
    at_once = max(1, PAIRS_AT_ONCE // len(rows))
    for first in range(0, len(rows), at_once):
        near = np.nonzero(single[first : first + at_once] @ single[first:].T > ALIKE - SINGLE)
        mine, theirs = near[0] + first, near[1] + first
        kept = (theirs > mine) & (of[mine] != of[theirs])
        mine, theirs = mine[kept], theirs[kept]
        sure = _products(rows, mine, theirs) > ALIKE
        yield mine[sure], theirs[sure]


def _products(rows: Floats, mine: Ints, theirs: Ints) -> Floats:
    products: Floats = np.einsum("ij,ij->i", rows[mine], rows[theirs])
    return products
