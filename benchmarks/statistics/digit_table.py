"""Tables of digits: one row a data set, one column a way."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

NIST = Path(os.environ.get("EMG2VSA_TEST_DATA", Path(__file__).resolve().parents[3] / "shared" / "data")) / "nist"


@dataclass(frozen=True)
class DigitTable:
    """rows : of each data set, digits by the name of the way."""

    title: str
    rows: Mapping[str, Mapping[str, float]]

    def column(self, way: str) -> np.ndarray:
        return np.array([row[way] for row in self.rows.values()])

    def show(self) -> None:
        ways = list(next(iter(self.rows.values())))
        width = [max(6, len(way) + 2) for way in ways]
        print(f"\n{self.title}\n{'':12}{''.join(f'{way:>{w}}' for way, w in zip(ways, width, strict=True))}")
        for name, row in self.rows.items():
            print(f"{name:12}{''.join(f'{row[way]:{w}.1f}' for way, w in zip(ways, width, strict=True))}", flush=True)


def files(folder: str) -> list[Path]:
    """The data files of one of NIST's collections, none where they are absent."""
    found = sorted((NIST / folder).glob("*.dat"))
    if not found:
        print(f"\nNIST's {folder} is not in {NIST}: skipped (EMG2VSA_TEST_DATA names the folder above nist).")
    return found
