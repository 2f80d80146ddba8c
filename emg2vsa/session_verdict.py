"""Is this participant's session good? The coordinator's question, answered from the trials of its recordings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from emg2vsa.fits import Fits
from emg2vsa.trials import Trials
from emg2vsa.trials.reasons import grouped

MIN_USABLE_SHARE = 0.8
"""A specimen with a smaller share of usable presses should be recorded again while the participant is there."""

VERDICTS = ("good", "usable", "repeat", "unreadable")
"""From best to worst; a session is as good as its worst recording."""


@dataclass(frozen=True)
class SpecimenVerdict:
    """One recording: presses found, wanted (None where the study does not say), and how they were judged.

    fault : why it cannot be judged at all, which recording again would not change; empty if it can. problems : what
    was found on the presses, one line per kind.
    """

    specimen: str
    found: int
    wanted: int | None
    ok: int
    warned: int
    rejected: int
    fault: str
    problems: tuple[str, ...]
    clean: bool = True
    "Nothing is doubtful about the recording as a whole."

    @property
    def usable(self) -> int:
        return self.ok + self.warned

    @property
    def verdict(self) -> str:
        """One of ``VERDICTS``."""
        if self.fault:
            return "unreadable"
        if self.usable < MIN_USABLE_SHARE * max(self.wanted or self.found, 1):
            return "repeat"
        return "good" if self.clean and self.ok == (self.wanted or self.found) == self.found else "usable"

    @property
    def advice(self) -> tuple[str, ...]:
        """What to do about this recording, a sentence each; nothing for a good one."""
        if self.verdict == "unreadable":
            return (f"{self.specimen}: cannot be used: {self.fault}",)
        if self.verdict == "repeat":
            presses = [f"{self.usable} usable presses of {self.wanted or self.found}"] if self.found else []
            return (f"{self.specimen}: record again ({'; '.join([*presses, *self.problems])}).",)
        return tuple(f"{self.specimen}: {problem}" for problem in self.problems)


@dataclass(frozen=True)
class SessionVerdict:
    """``good``: every press as wanted; ``usable``: go on, with what ``advice`` says; ``repeat``: record some again;
    ``unreadable``: some recording cannot be judged before its file or the study file is put right."""

    participant: str
    verdict: str
    specimens: tuple[SpecimenVerdict, ...]
    advice: tuple[str, ...]


def judge_session(
    participant: str,
    trials: Sequence[Trials],
    fits: Mapping[str, Fits],
    wanted: Mapping[str, int | None],
    failures: Mapping[str, str],
    doubts: Mapping[str, Sequence[str]] | None = None,
) -> SessionVerdict:
    """Judge one participant's recordings.

    Parameters
    ----------
    trials : those of the recordings that could be read. fits : specimen to their fits, whose verdicts count, for they
    know more than the trials. wanted : specimen to the number of presses it should hold, for every recording of the
    session. failures : specimen to why its recording could not be used. doubts : specimen to what is doubtful about
    its recording beside others.
    """
    by_specimen = {t.specimen: t for t in trials}
    specimens = tuple(
        _judge_recording(by_specimen[name], fits.get(name), count, (doubts or {}).get(name, ()))
        if name in by_specimen
        else SpecimenVerdict(name, 0, count, 0, 0, 0, failures.get(name, "no recording"), ())
        for name, count in wanted.items()
    )
    worst_first = sorted(specimens, key=lambda s: -VERDICTS.index(s.verdict))
    verdict = worst_first[0].verdict if worst_first else "good"
    return SessionVerdict(participant, verdict, specimens, tuple(line for s in worst_first for line in s.advice))


def _judge_recording(trials: Trials, fits: Fits | None, wanted: int | None, doubts: Sequence[str]) -> SpecimenVerdict:
    judged, reasons = (trials.verdict, trials.reasons) if fits is None else (fits.verdict, fits.reason.tolist())
    ok, warned, rejected = (int(np.sum(judged == v)) for v in ("ok", "warned", "rejected"))
    found = len(trials.repetition)
    problems = grouped(zip(trials.repetition.tolist(), judged.tolist(), reasons, strict=True))
    problems = [] if trials.fault else [*trials.remarks, *doubts, *problems]
    if wanted is not None and found != wanted:
        problems.insert(0, f"{found} presses found, {wanted} wanted")
    if not found:
        problems += [note for note in trials.notes if note.startswith("presses: none")]
    clean = not trials.remarks and not doubts
    return SpecimenVerdict(trials.specimen, found, wanted, ok, warned, rejected, trials.fault, tuple(problems), clean)
