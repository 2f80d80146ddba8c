"""A path of analysis: which choices it makes, and the claims that come of them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from emg2vsa.claims.claim import Claim

INDEX, LAW, BINS, WEIGHTS, INTERPOLATION = "index", "law of force", "force bins", "weights", "interpolation"
EXCLUSIONS = "exclusions"
PERSON, REPETITION = "person left out", "repetition left out"
ALGORITHM, RATE, KAPPA, MOUNTING_SD = "vision algorithm", "rate rule", "law of κ", "SD of mountings"
MOUNTING, PRESS, SPECIMEN = "mounting left out", "press left out", "specimen left out"
SEVERAL = "several at once"
KINDS = (
    INDEX, LAW, BINS, WEIGHTS, INTERPOLATION, EXCLUSIONS, PERSON, REPETITION, ALGORITHM, RATE, MOUNTING_SD,
    KAPPA, MOUNTING, PRESS, SPECIMEN, SEVERAL,
)  # fmt: skip
"""Kinds of choices, as people read them; a path that makes two choices or more is of the last."""


@dataclass(frozen=True)
class Choice:
    """A choice that the study did not make. kind : of ``KINDS``. says : in a few words."""

    kind: str
    says: str


@dataclass(frozen=True)
class Tried:
    """The claims along one path. choices : those that differ from the study's, none for its own path. not_on : keys of
    claims on which these choices cannot bear."""

    choices: tuple[Choice, ...]
    claims: tuple[Claim, ...]
    not_on: frozenset[str] = frozenset()

    @property
    def kind(self) -> str:
        """One of ``KINDS``; ""  for the study's own path."""
        kinds = [choice.kind for choice in self.choices]
        return SEVERAL if len(kinds) > 1 else "".join(kinds)

    @property
    def name(self) -> str:
        """All choices in words."""
        return ", ".join(choice.says for choice in self.choices)


def tried(choices: Iterable[Choice | None], claims: Iterable[Claim], not_on: Iterable[str] = ()) -> Tried:
    """The path of these ``choices``; None: as the study chose."""
    return Tried(tuple(filter(None, choices)), tuple(claims), frozenset(not_on))
