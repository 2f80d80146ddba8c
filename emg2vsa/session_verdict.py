"""Is this participant's session good? The coordinator's question, answered from the trials of its recordings."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from emg2vsa.arrays import median
from emg2vsa.extraction import Trials
from emg2vsa.extraction.diagnosis import ranked
from emg2vsa.extraction.reasons import PRESSES_NAMED, grouped, put_aside
from emg2vsa.extraction.remedies import at_the_desk, remedy_of
from emg2vsa.fits import Fits, usable
from emg2vsa.settings import PressJudgement

LAG_APART_S = 0.03
"""Recordings of a session whose lags differ by more from their median were not started alike."""
MIN_OTHERS, CLEARLY = 3, 4.0
"""So many others must agree on the order of two specimens, and so many standard errors make a difference clear."""
MIN_USABLE_SHARE = 0.8
"""A specimen with a smaller share of usable presses should be recorded again while the participant is there."""

VERDICTS = ("good", "usable", "repeat", "unreadable")
"""Verdicts from best to worst; a session is as good as its worst recording."""


class Advice(NamedTuple):
    """``text``: what was found. ``do``: the remedy, "" where none is known or the text holds it."""

    text: str
    do: str

    def __str__(self) -> str:
        return f"{self.text} -> {self.do}" if self.do else self.text


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
    doubtful: int
    rejected: int
    fault: str
    problems: tuple[str, ...]
    clean: bool = True
    "Nothing is doubtful about the recording as a whole."
    cause: str = ""
    "Most likely, of the problems; empty where nobody knows one, or the fault is it."
    remedy: str = ""
    "What to do about the cause, or about the fault."

    @property
    def verdict(self) -> str:
        """One of ``VERDICTS``."""
        if self.fault:
            return "unreadable"
        if self.ok < MIN_USABLE_SHARE * max(self.wanted or self.found, 1):
            return "repeat"
        return "good" if self.clean and self.ok == (self.wanted or self.found) == self.found else "usable"

    @property
    def advice(self) -> tuple[Advice, ...]:
        """What was found about this recording, and what to do; nothing for a good one."""
        if self.verdict == "unreadable":
            return (Advice(f"{self.specimen}: cannot be used: {self.fault}", self.remedy),)
        told = [Advice(f"{self.specimen}: {text}", do) for text, do in self.told]
        if self.verdict == "repeat":
            presses = f" ({self.ok} usable presses of {self.wanted or self.found})" if self.found else ""
            what = "mend it before it is recorded again" if at_the_desk(self.remedy) else "record again"
            return (Advice(f"{self.specimen}: {what}{presses}", ""), *told)
        return tuple(told)

    @property
    def told(self) -> tuple[Advice, ...]:
        """The fault or the problems, the most likely cause first, which alone has a remedy: the rest follows from it,
        or is seen better once it is mended."""
        if self.fault:
            return (Advice(self.fault, self.remedy),)
        for place, problem in enumerate(self.problems):
            if re.sub(PRESSES_NAMED, "", problem) == self.cause:
                rest = (*self.problems[:place], *self.problems[place + 1 :])
                return (Advice(problem, self.remedy), *(Advice(each, "") for each in rest))
        most_likely = (Advice(f"most likely: {self.cause}", self.remedy),) if self.cause else ()
        return (*most_likely, *(Advice(problem, "") for problem in self.problems))


@dataclass(frozen=True)
class SessionVerdict:
    """``good``: every press as wanted; ``usable``: go on, with what ``advice`` says; ``repeat``: record some again;
    ``unreadable``: some recording cannot be judged before its file or the study file is put right."""

    participant: str
    verdict: str
    specimens: tuple[SpecimenVerdict, ...]
    advice: tuple[Advice, ...]
    b: tuple[dict[str, str | int | float | None], ...] = ()
    "Mean b of the presses used, by specimen; its interval holds how presses of the whole study differ."
    law: str = ""
    "Whether v = a + b ln F fits the presses that are ok, and what is nearer; another recording does not change it."
    law_fits: bool = True
    "False where it does not."


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
        else SpecimenVerdict(
            name, 0, count, 0, 0, 0, failures.get(name, "no recording"), (), remedy=remedy_of(failures.get(name, ""))
        )
        for name, count in wanted.items()
    )
    worst_first = sorted(specimens, key=lambda s: -VERDICTS.index(s.verdict))
    verdict = worst_first[0].verdict if worst_first else "good"
    return SessionVerdict(participant, verdict, specimens, tuple(line for s in worst_first for line in s.advice))


def _judge_recording(trials: Trials, fits: Fits | None, wanted: int | None, doubts: Sequence[str]) -> SpecimenVerdict:
    judged, reasons = (trials.verdict, trials.reasons) if fits is None else (fits.verdict, fits.reason.tolist())
    # presses that were repeated while the participant was there are told, and missing to nobody
    counted = np.array([not put_aside(reason) for reason in reasons], dtype=np.bool_)
    ok, doubtful, rejected = (int(np.sum(judged[counted] == v)) for v in ("ok", "doubtful", "rejected"))
    found = int(np.sum(counted))
    by_press = grouped(zip(trials.repetition.tolist(), judged.tolist(), reasons, strict=True))
    # presses of a recording with a fault are used only where a person accepts all of it; the fault is then a remark
    fault = "" if ok + doubtful else trials.fault
    problems = [] if fault else [*trials.remarks, *doubts, *by_press]
    if wanted is not None and found != wanted:
        problems.insert(0, f"{found} presses found, {wanted} wanted")
    if not found:
        problems += [note for note in trials.notes if note.startswith("presses: none")]
    clean = not trials.remarks and not doubts and not trials.fault
    pressed = set(by_press)
    causes = ranked((line for line in problems if line not in pressed), zip(judged.tolist(), reasons, strict=True))
    cause, remedy = causes[0][:2] if causes and not fault else ("", remedy_of(fault))
    return SpecimenVerdict(
        trials.specimen, found, wanted, ok, doubtful, rejected, fault, tuple(problems), clean, cause, remedy
    )


Doubts = dict[tuple[str, str], list[str]]
"""(participant, specimen) to what is doubtful about the recording beside others."""


def doubts_between(
    trials: Sequence[Trials], fits: Mapping[tuple[str, str], Fits], judgements: Sequence[PressJudgement] = ()
) -> Doubts:
    """What only a look at several recordings shows, as far as they are given.

    fits : (participant, specimen) to the fits of the recording, screened; one without is looked at for little.
    """
    found: Doubts = {}
    slopes = {key: (one, usable(one, "ok")) for key, one in fits.items()}
    tellers = (_apart(trials), _swapped(slopes), _unknown(trials, judgements))
    for tell in tellers:
        for key, said in tell:
            found.setdefault(key, []).append(said)
    return found


Told = Iterator[tuple[tuple[str, str], str]]


def _apart(trials: Sequence[Trials]) -> Told:
    sessions: dict[str, list[Trials]] = {}
    for one in trials:
        if one.lag_se_s < LAG_APART_S / 3:
            sessions.setdefault(one.participant, []).append(one)
    for known in sessions.values():
        typical_s = median(np.array([one.lag_s for one in known]))
        for one in known:
            if len(known) >= 3 and abs(one.lag_s - typical_s) > LAG_APART_S:
                apart = f"{1e3 * abs(one.lag_s - typical_s):.0f} ms from the {1e3 * typical_s:.0f} ms of the session"
                yield (one.participant, one.specimen), f"lag of force is {apart}"


Slopes = Mapping[tuple[str, str], tuple[Fits, NDArray[np.bool_]]]
"""(participant, specimen) to the fits of the recording, and which of them are used."""


def _swapped(slopes: Slopes) -> Told:
    """Two specimens whose slopes one participant has the other way round, clearly, and all others agree."""
    means: dict[str, dict[str, tuple[float, float]]] = {}
    for (participant, specimen), (fits, used) in slopes.items():
        b_v = fits.b_v[used]
        if b_v.size >= 3:
            mean_var = float(np.mean(b_v)), float(np.var(b_v, ddof=1) / b_v.size)
            means.setdefault(participant, {})[specimen] = mean_var
    order = {
        (participant, name, other): (own[name][0] - own[other][0], own[name][1] + own[other][1])
        for participant, own in means.items()
        for name, other in combinations(sorted(own), 2)
    }
    people = Counter((name, other) for _, name, other in order)
    above = Counter((name, other) for (_, name, other), (difference, _) in order.items() if difference > 0)
    for (participant, name, other), (difference, variance) in order.items():
        others, as_own = people[name, other] - 1, above[name, other] - 1 if difference > 0 else 0
        if difference < 0:
            as_own = people[name, other] - above[name, other] - 1
        if others < MIN_OTHERS or as_own or difference**2 <= CLEARLY**2 * variance:
            continue
        way = "above" if difference > 0 else "below"
        said = f"b of {name} is {way} that of {other}, against all other participants; were {name} and {other} swapped?"
        yield (participant, name), said
        yield (participant, other), said


def _unknown(trials: Sequence[Trials], judgements: Sequence[PressJudgement]) -> Told:
    found = {(t.participant, t.specimen): t.repetition.size for t in trials}
    for judgement in judgements:
        key = (judgement.participant, judgement.specimen)
        if judgement.repetition is not None and judgement.repetition > found.get(key, judgement.repetition):
            kind = "exclude" if judgement.excludes else "accept"
            yield key, f"[[{kind}]] names press {judgement.repetition}, of {found[key]} found"
