"""Whole studies of people as tables of presses, made in milliseconds: what is claimed of them is known."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from emg2vsa.claims.people import PressTable
from emg2vsa.profiles import ByPerson

STIFFNESS = {"S1": 7.63, "S2": 5.32, "S3": 3.35, "S4": 3.12, "S5": 1.11}
KEPT = ("S1", "S3", "S5")


@dataclass(frozen=True)
class People:
    """Levels of b in % of each other; SDs in the same unit.

    order : of acquisition: "random" for each person, "same" for all, "unknown" (the same, but not recorded), "two" of
    the people in reverse order and the others not. drift : from the first press of a session to its last, in SDs of a
    press; rates : SD of its rate from person to person, over its mean. person : SD of gains, over 1. slopes : SD of
    person by specimen. tails : degrees of freedom of t-distributed presses.
    """

    b: tuple[float, ...] = (100.0,) * 5
    people: int = 14
    presses: int = 10
    press: float = 15.0
    person: float = 0.2
    slopes: float = 0.0
    drift: float = 0.0
    rates: float = 0.3
    order: str = "random"
    tails: float = np.inf
    lost: int = 0
    "Recordings that are missing."

    def presses_of(self, seed: int) -> PressTable:
        rng = np.random.default_rng(seed)
        n, s, r = self.people, len(self.b), self.presses
        who, what, number = (axis.ravel() for axis in np.indices((n, s, r)))
        listed = np.tile(np.arange(1.0, s + 1), (n, 1))
        if self.order == "random":
            listed = rng.permuted(listed, axis=1)
        if self.order == "two":
            listed[:2] = listed[:2, ::-1]
        place = listed[who, what]
        noise = rng.standard_normal(who.size) if np.isinf(self.tails) else rng.standard_t(self.tails, who.size)
        rate = self.drift / (s * r) * (1 + self.rates * rng.standard_normal(n))
        mean = np.array(self.b) * (1 + self.person * rng.standard_normal((n, 1)))
        mean = mean + self.slopes * rng.standard_normal((n, s))
        b = mean[who, what] + self.press * (noise + rate[who] * ((place - 1) * r + number))
        known = np.full(place.shape, np.nan) if self.order == "unknown" else place
        names = np.array(list(STIFFNESS)[:s])
        cells = rng.permutation(n * s)[self.lost :]
        there = np.isin(who * s + what, cells)
        columns = np.char.mod("P%02d", who), names[what], number + 1, np.full(b.shape, 150.0), b, known
        return PressTable(*(column[there] for column in columns))


def profile_of(table: PressTable, taken: np.ndarray | None = None) -> ByPerson:
    """Of a table without gaps: S2 beside its interpolation between S1 and S3, by stiffness; or beside ``taken`` (P, 2),
    a and b that somebody says were interpolated."""
    people = np.unique(table.participant)

    def mean(specimen: str) -> np.ndarray:
        own = [(table.participant == who) & (table.specimen == specimen) for who in people]
        return np.array([[table.a_v[rows].mean(), table.b_v[rows].mean()] for rows in own])

    stiffer, softer, measured = mean("S1"), mean("S3"), mean("S2")
    weight = (STIFFNESS["S1"] - STIFFNESS["S2"]) / (STIFFNESS["S1"] - STIFFNESS["S3"])
    made = (1 - weight) * stiffer + weight * softer if taken is None else taken
    return ByPerson(tuple(people.tolist()), "S2", ("S1", "S3"), made, measured, stiffer, softer)
