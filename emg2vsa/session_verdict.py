"""Is this participant's session good? The coordinator's question, answered from the trials of its recordings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from emg2vsa.trials import Trials

MIN_USABLE_SHARE = 0.8
"""A specimen with a smaller share of usable presses should be recorded again while the participant is there."""


@dataclass(frozen=True)
class SpecimenVerdict:
    """One recording: presses found, wanted (None where the study does not say), and how they were judged."""

    specimen: str
    found: int
    wanted: int | None
    ok: int
    warned: int
    rejected: int
    problems: tuple[str, ...]

    @property
    def usable(self) -> int:
        return self.ok + self.warned

    @property
    def enough(self) -> bool:
        return self.usable >= MIN_USABLE_SHARE * max(self.wanted or self.found, 1)


@dataclass(frozen=True)
class SessionVerdict:
    """``good``: every press as wanted; ``usable``: go on, with what ``advice`` says; ``repeat``: record some again."""

    participant: str
    verdict: str
    specimens: tuple[SpecimenVerdict, ...]
    advice: tuple[str, ...]


def judge_session(
    participant: str, trials: Sequence[Trials], wanted: Mapping[str, int | None], failures: Mapping[str, str]
) -> SessionVerdict:
    """Judge one participant's recordings.

    Parameters
    ----------
    trials : those of the recordings that could be read. wanted : specimen to the number of presses it should hold, for
    every recording of the session. failures : specimen to why its recording could not be used.
    """
    by_specimen = {t.specimen: t for t in trials}
    specimens = tuple(
        _judge_recording(name, by_specimen.get(name), count, failures.get(name)) for name, count in wanted.items()
    )
    again = [s for s in specimens if not s.enough]
    advice = [f"{s.specimen}: record again ({_why(s)})." for s in again]
    advice += [f"{s.specimen}: {problem}" for s in specimens if s.enough for problem in s.problems]
    good = all(s.ok == (s.wanted or s.found) == s.found for s in specimens)
    verdict = "repeat" if again else "good" if good else "usable"
    return SessionVerdict(participant, verdict, specimens, tuple(advice))


def _judge_recording(name: str, trials: Trials | None, wanted: int | None, failure: str | None) -> SpecimenVerdict:
    if trials is None:
        return SpecimenVerdict(name, 0, wanted, 0, 0, 0, (failure or "no recording",))
    ok, warned, rejected = (int(np.sum(trials.verdict == v)) for v in ("ok", "warned", "rejected"))
    found = len(trials.repetition)
    problems = [
        f"press {repetition} {verdict}: {reason}"
        for repetition, verdict, reason in zip(trials.repetition, trials.verdict, trials.reasons, strict=True)
        if reason
    ]
    if wanted is not None and found != wanted:
        problems.insert(0, f"{found} presses found, {wanted} wanted")
    return SpecimenVerdict(name, found, wanted, ok, warned, rejected, tuple(problems))


def _why(specimen: SpecimenVerdict) -> str:
    if not specimen.found:
        return "; ".join(specimen.problems)
    return f"{specimen.usable} usable presses of {specimen.wanted or specimen.found}; " + "; ".join(specimen.problems)
