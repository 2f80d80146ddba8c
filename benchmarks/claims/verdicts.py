"""What is false of the verdicts of a world, and how often a true claim is found."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from scipy import special

LETTERS = {"holds": "h", "refuted": "r", "not determined": "n"}
NOTHING = 0.25
"Share of the margin: an estimand of a claim that something is more, below it, counts as nothing."


class Truth(NamedTuple):
    """An estimand with its margin; asserts : "more" or "within"."""

    value: float
    margin: float
    asserts: str

    def wrong(self, letter: str) -> bool:
        """Whether this verdict is false: "holds" of what is not so, "refuted" of what is so by the margin."""
        if self.value != self.value:
            return False
        if self.asserts == "more":
            return self.value < NOTHING * self.margin if letter == "h" else letter == "r" and self.value >= self.margin
        return self.value >= self.margin if letter == "h" else letter == "r" and self.value <= self.margin

    @property
    def right(self) -> str:
        """The verdict that is asked for, "" where the world has no such estimand."""
        if self.value != self.value:
            return ""
        held = self.value >= NOTHING * self.margin if self.asserts == "more" else self.value < self.margin
        return "h" if held else "r"


def upper(count: int, n: int, confidence: float = 0.95) -> float:
    """Clopper and Pearson's upper bound of a rate, one-sided."""
    return 1.0 if count >= n else float(special.betaincinv(count + 1, n - count, confidence))


class Rate(NamedTuple):
    """count of n studies."""

    count: int
    n: int

    @property
    def share(self) -> float:
        return self.count / self.n if self.n else float("nan")

    @property
    def bound(self) -> float:
        return upper(self.count, self.n)


def false_rates(verdicts: Mapping[str, str], truths: Mapping[str, Truth]) -> dict[str, Rate]:
    """Claim to how often its verdict is false; verdicts : claim to a letter of each study."""
    return {key: Rate(sum(truths[key].wrong(x) for x in letters), len(letters)) for key, letters in verdicts.items()}


def any_false(verdicts: Mapping[str, str], truths: Mapping[str, Truth]) -> Rate:
    """Studies with any false verdict."""
    wrong = np.array([[truths[key].wrong(x) for x in letters] for key, letters in verdicts.items()])
    return Rate(int(np.count_nonzero(wrong.any(axis=0))), wrong.shape[1])


def powers(verdicts: Mapping[str, str], truths: Mapping[str, Truth]) -> dict[str, Rate]:
    """Claim to how often its right verdict is found, of claims that have one."""
    right = {key: truths[key].right for key in verdicts}
    return {key: Rate(letters.count(right[key]), len(letters)) for key, letters in verdicts.items() if right[key]}


def joined(parts: Sequence[Mapping[str, str]]) -> dict[str, str]:
    """Verdicts of chunks of studies of one world, one after the other."""
    return {key: "".join(part[key] for part in parts) for key in parts[0]} if parts else {}
