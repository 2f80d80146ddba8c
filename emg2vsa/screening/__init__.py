"""Recordings that are unlike all others of their study: a changed gain, filters in the file, a wrong clock, copies.

The product stands apart from its making (``emg2vsa.screening.screen``), so that what applies it loads no arithmetic.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from emg2vsa.extraction import Trials
from emg2vsa.fits import Fits

Verdict = Literal["ok", "told", "doubtful", "unreadable"]
"told: b is as good as right, and the recording is used. ok: somebody accepted the recording by name."


@dataclass(frozen=True)
class Screened:
    """What was found about one recording.

    cause : short name. text : the sentence for people. b_share : expected factor on b minus 1, NaN where unknown.
    """

    participant: str
    specimen: str
    cause: str
    text: str
    b_share: float
    verdict: Verdict

    @property
    def said(self) -> str:
        """The text, with what b is expected to be off by."""
        if not math.isfinite(self.b_share):
            return self.text
        off = f"{1 + self.b_share:.3g} times" if self.b_share > 1 else f"{100 * self.b_share:+.0f} %"
        return f"{self.text} (b {off})"


@dataclass(frozen=True)
class Screening:
    """One entry for each recording of a study about which something was found, in the study's order.

    unequal : participant, visit, and the specimens that miss there though the participant pressed them at another one.
    """

    found: tuple[Screened, ...] = ()
    unequal: tuple[tuple[str, str, str], ...] = ()

    def counts(self, participant: str, specimen: str, use: str) -> bool:
        """Whether presses of a recording can enter a test. use : `[hypotheses] use`."""
        found = self.of(participant, specimen)
        verdict = "ok" if found is None or found.verdict == "told" else found.verdict
        return verdict in use.split("+")

    def of(self, participant: str, specimen: str) -> Screened | None:
        """What was found about a recording and was not accepted; None for nothing."""
        return next((each for each in self.about({(participant, specimen)}) if each.verdict != "ok"), None)

    def about(self, cells: Collection[tuple[str, str]]) -> Iterator[Screened]:
        """What was found about these recordings, each a participant and a specimen."""
        for cell in cells:
            yield from self._of_cell.get(cell, ())

    @cached_property
    def _of_cell(self) -> dict[tuple[str, str], list[Screened]]:
        """A study of thousands asks for each of its recordings."""
        found: dict[tuple[str, str], list[Screened]] = {}
        for each in self.found:
            found.setdefault((each.participant, each.specimen), []).append(each)
        return found


def screened(fits: Fits, screening: Screening | None) -> Fits:
    """Fits, of one recording or many, as the study sees them: ok presses of a doubtful recording are doubtful, all
    presses of an unreadable one rejected, each with the reason. Doubtful too are those of a visit that lacks a
    specimen: what differs between visits would be taken for a difference of specimens."""
    verdict, reason = fits.verdict.copy(), fits.reason.astype(object)

    def touch(touched: NDArray[np.bool_], becomes: str, said: str) -> None:
        verdict[touched] = becomes
        for i in np.flatnonzero(touched).tolist():
            reason[i] = f"{said}; {reason[i]}" if reason[i] else said

    cells = set(zip(fits.participant.tolist(), fits.specimen.tolist(), strict=True))
    for each in screening.about(cells) if screening else ():
        own = (fits.participant == each.participant) & (fits.specimen == each.specimen)
        if each.verdict == "doubtful":
            touch(own & (verdict == "ok"), "doubtful", each.said)
        elif each.verdict == "unreadable":
            touch(own, "rejected", each.said)
    for who, visit, lacks in screening.unequal if screening else ():
        said = f"visit {visit} lacks {lacks}, so that its presses would bias comparisons of specimens"
        touch((fits.participant == who) & (fits.visit == visit) & (verdict == "ok"), "doubtful", said)
    return replace(
        fits, verdict=verdict, reason=reason.astype(fits.reason.dtype if fits.reason.dtype == object else str)
    )


def screened_trials(trials: Trials, screening: Screening | None) -> Trials:
    """Trials of which an unreadable recording has its fault, and one about which something is told the remark."""
    found = screening.of(trials.participant, trials.specimen) if screening else None
    if found is None or found.verdict == "doubtful" or trials.fault:
        return trials
    if found.verdict == "told":
        return replace(trials, remarks=(*trials.remarks, found.said))
    return replace(trials, fault=found.said)
