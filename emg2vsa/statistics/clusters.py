"""One number per trial, sorted into a table of participants by specimens by repetitions."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from emg2vsa.arrays import Floats, Ints

Names = NDArray[np.str_]


@dataclass(frozen=True)
class Clusters:
    """participants (P,), specimens (S,), values (P, S, R), NaN beyond the repetitions of a cluster, count (P, S)."""

    participants: Names
    specimens: Names
    values: Floats
    count: Ints


def clusters_of(participant: Names, specimen: Names, values: Floats, admitted: NDArray[np.bool_]) -> Clusters:
    """Sort the ``admitted`` of n trials (all arrays (n,)); participants and specimens in natural order of their names.

    A participant or specimen none of whose trials is admitted keeps its (empty) place.
    """
    participants, specimens = in_order(participant), in_order(specimen)
    shape = (participants.size, specimens.size)
    cell = _position(participant[admitted], participants) * shape[1] + _position(specimen[admitted], specimens)
    count = np.bincount(cell, minlength=shape[0] * shape[1])
    order = np.argsort(cell, kind="stable")
    repetition = np.arange(cell.size) - np.repeat(np.cumsum(count) - count, count)
    table = np.full((count.size, max(int(count.max(initial=0)), 1)), np.nan)
    table[cell[order], repetition] = values[admitted][order]
    return Clusters(participants, specimens, table.reshape(*shape, -1 if count.size else 1), count.reshape(shape))


def in_order(names: Names) -> Names:
    """Distinct names; numbers in them compare as numbers, S2 before S10."""
    return np.array(sorted(set(names.tolist()), key=_natural), dtype=np.str_)


def _natural(name: str) -> list[tuple[int, str]]:
    return [(int(part), part) if part.isdecimal() else (-1, part) for part in re.split(r"(\d+)", name)]


def _position(names: Names, ordered: Names) -> Ints:
    place = {name: i for i, name in enumerate(ordered.tolist())}
    return np.array([place[name] for name in names.tolist()], dtype=np.int64)
