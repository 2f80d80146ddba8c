"""What the study claims of the stiffness of the new specimen.

How far off is kappa of the new specimen, and does the error shrink from one design to another? By the one estimate of
the study: by the pins, or where these tell none by the law through CASR. What names a vision algorithm is by that law,
and so is how far off the known specimens are that it was fitted to.
An interval of kappa holds its true value, so that of kappa over the known stiffness, minus 1, holds what the estimate
and the condition are off by once presses and mountings are averaged out. A design in which kappa is not determined has
no error here.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from emg2vsa.calibration.results import Headline, LawResult, PinsResult
from emg2vsa.claims import paper
from emg2vsa.claims.claim import UNKNOWN, Asserts, Claim, Ends, Found, largest, size, smallest
from emg2vsa.settings import ClaimSettings

QUESTION = "stiffness of the new specimen"
PINS = "pins"
"""No algorithm of scores: the one estimate of the study, where it is by the pins."""
OLD, NEW = "circle", "paper"
"""Vision algorithms of the previous work, and of the paper: hexagons and its equations."""
_RIGID, _HUMAN_LIKE = "high-stiffness", "modular"

Design = tuple[str, float]
"""Condition and angle."""
DESIGNS: dict[str, tuple[str, tuple[Design, ...]]] = {
    "rigid": ("rigid motor", tuple((_RIGID, angle) for angle in paper.ERROR_NEW_VISION)),
    "human_like": ("human-like stiffness", tuple((_HUMAN_LIKE, angle) for angle in paper.ERROR_HUMAN_LIKE)),
    "constant": ("constant stiffness", tuple((condition, 0.0) for condition in paper.ERROR_CONSTANT)),
}
"""What the paper says an error of kappa of: key to what people call it, and its designs."""


@dataclass(frozen=True)
class Step:
    """Step from one condition and algorithm to another, ""  for the one estimate of the study, at these angles."""

    says: str
    before: tuple[str, str]
    after: tuple[str, str]
    angles_deg: tuple[float, ...]


STEPS = {
    "vision": Step("hexagons, not the circle, cut the error of κ", (_RIGID, OLD), (_RIGID, NEW), (30.0, 45.0)),
    "human_like": Step("human-like stiffness cuts the error of κ", (_RIGID, ""), (_HUMAN_LIKE, ""), (30.0, 45.0)),
    "both": Step("both together cut the error of κ", (_RIGID, OLD), (_HUMAN_LIKE, NEW), (0.0, 30.0, 45.0)),
}


class Laws(Protocol):
    """What gives the estimate of a design, and its law by a vision algorithm; None where it was not calibrated."""

    def headline(self, condition: str, angle_deg: float, algorithm: str) -> Headline | None:
        """Kappa by the pins, or by the law of ``algorithm``. angle_deg : degrees."""

    def law(self, condition: str, angle_deg: float, algorithm: str) -> LawResult | None:
        """By CASR. angle_deg : degrees."""


def kappa_claims(found: Laws, own: str, margins: ClaimSettings, *, hexagons: bool = True) -> Iterator[Claim]:
    """own : vision algorithm of the study. hexagons : whether the algorithm "paper" takes its areas from hexagons."""
    error, points = margins.kappa_error_percent / 100, margins.reduction_points / 100
    for key, (what, designs) in DESIGNS.items():
        laws = [found.law(*design, own) for design in designs]
        ours = [found.headline(*design, own) for design in designs]
        yield _claim(
            f"kappa_fit_{key}", f"a law of CASR gives κ, {what}", "largest error of a known specimen by it, %",
            "within", largest(_fitted(laws)), error, own, _lacking(designs, laws), designs,
        )  # fmt: skip
        yield _claim(
            f"kappa_error_{key}", f"the error of κ is small, {what}", "largest error of κ, %", "within",
            largest(size(_error(one)) for one in ours), error, f"{PINS}, else {own}",
            _lacking(designs, ours, determined=True), designs,
        )  # fmt: skip
    for key, step in STEPS.items():
        before, after = ((condition, algorithm or own) for condition, algorithm in (step.before, step.after))
        both = [(condition, angle) for condition, _ in (before, after) for angle in step.angles_deg]
        by: list[Headline | None] = [
            found.law(c, angle, name) for c, name in (before, after) for angle in step.angles_deg
        ]
        ways = " to ".join(dict.fromkeys((before[1], after[1])))
        if not step.before[1]:
            ours, ways = [found.headline(*design, own) for design in both], f"{PINS}, else {own}"
            by = ours if all(isinstance(one, PinsResult) for one in ours) else by  # not one by pins, one by CASR
        n, told = len(step.angles_deg), hexagons or NEW not in (before[1], after[1])
        cut = smallest(_cut(_error(old), _error(new)) for old, new in zip(by[:n], by[n:], strict=True))
        yield _claim(
            f"reduction_{key}", f"{step.says}, {'/'.join(f'{angle:g}' for angle in step.angles_deg)}°",
            "smallest cut of the size of the error, points", "more", cut if told else UNKNOWN, points,
            ways,
            _lacking(both, by, determined=True) if told else "The area rule of this study is not of hexagons.",
            both,
        )  # fmt: skip


def _claim(
    key: str, says: str, estimand: str, asserts: Asserts, found: Found, margin: float, algorithm: str, why: str,
    designs: Sequence[Design],
) -> Claim:  # fmt: skip
    return Claim(
        key, QUESTION, says, estimand, asserts, found, margin, "mounting", "kappa", algorithm, 100, why, tuple(designs)
    )


def _error(one: Headline | None) -> Found:
    """kappa over the known kappa, minus 1."""
    if one is None or not one.determined:
        return UNKNOWN
    by = one if isinstance(one, PinsResult) else next(iter(one.on_laws), None)
    return Found(by.error, one.error_interval) if by else UNKNOWN


def _fitted(laws: Iterable[LawResult | None]) -> Iterator[Found]:
    """Size of the error of each known specimen by the law that was fitted to all of them."""
    for law in laws:
        if law is None:
            yield UNKNOWN
        else:
            yield from (size(Found(each.error, each.error_interval)) for each in law.fitted_on_law)


def _cut(before: Found, after: Found) -> Found:
    """Size of one error less that of another, of errors that are independent or rise together.

    Where both are certain to have the same sign, the variance is recovered at each end (Zou and Donner 2008). Else what
    raises both errors can make one larger and the other smaller, so that both parts of an end add up.
    """
    old, new = size(before), size(after)

    def interval(confidence: float) -> Ends:
        ends, other_ends = before.interval(confidence), after.interval(confidence)
        alike = min(*ends, *other_ends) > 0 or max(*ends, *other_ends) < 0
        (low, high), (other_low, other_high) = old.interval(confidence), new.interval(confidence)
        below = np.array([old.estimate - low, other_high - new.estimate])
        above = np.array([high - old.estimate, new.estimate - other_low])
        reach = np.linalg.norm if alike else np.sum
        difference = old.estimate - new.estimate
        return float(difference - reach(below)), float(difference + reach(above))

    return Found(old.estimate - new.estimate, interval)


def _lacking(designs: Sequence[Design], laws: Sequence[Headline | None], *, determined: bool = False) -> str:
    """One sentence on what is missing."""
    absent = [f"{c} {angle:g}°" for (c, angle), law in zip(designs, laws, strict=True) if law is None]
    if absent:
        return f"No calibration: {', '.join(dict.fromkeys(absent))}."
    if not determined:
        return _assumed(laws)
    told = [law.determined for law in laws if law is not None]
    if not all(told):
        by = "By CASR κ" if all(isinstance(law, LawResult) for law in laws) else "κ"
        return f"{by} is determined in {told.count(True)} of {len(told)} designs."
    if not all(law.error == law.error for law in laws if law):
        return "κ of the new specimen is not known."
    return _assumed(laws)


def _assumed(laws: Sequence[Headline | None]) -> str:
    by_casr = [law for law in laws if isinstance(law, LawResult)]
    sd = max((100 * law.mounting_sd for law in by_casr if law.mounting_freedom == 0), default=0.0)
    return f"Mounted once; an SD between mountings of {sd:g} % is assumed." if sd > 0 else ""
