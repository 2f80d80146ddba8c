"""Which step of Table I makes the error smaller, and whether the presses can say so: computed, not taken over."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from emg2vsa.arrays import Floats
from emg2vsa.calibration.results import AlgorithmResult, CalibrationResults
from emg2vsa.report.kappa_tables import COLUMNS, angles, column, holds
from emg2vsa.report.wording import count, listed, percent


@dataclass(frozen=True)
class _Errors:
    """One column of Table I at all angles (n,), sizes of errors as shares of the known κ; NaN where there is none.

    chosen, paper : by the law chosen and by the paper's. reach : half the interval; inf where it has no upper end.
    """

    name: str
    chosen: Floats
    paper: Floats
    reach: Floats


def kappa_conclusion(found: CalibrationResults, algorithm: str, old: str) -> str:
    """Does each step of Table I reduce the error? Counted over the angles that have both."""
    truth = found.known_kappa_new
    if np.isnan(truth):
        return f"The stiffness of {found.new_specimen} is not known, so that no error can be stated."
    names = ("the old one", "the new vision algorithm", "human-like stiffness")
    before, new, human = (
        _errors(name, column(found, key, algorithm, old), truth)
        for name, (key, _, _, _) in zip(names, COLUMNS, strict=True)
    )
    said = [
        _step(new, before, angles(found)),
        _step(human, replace(new, name="the rigid motor"), angles(found)),
        *(_intervals(found, name) for name in (algorithm, old)),
        _caution(found, algorithm),
    ]
    return " ".join(filter(None, said))


def _errors(name: str, of: Sequence[AlgorithmResult | None], truth: float) -> _Errors:
    rows = [
        (each.chosen.error, each.paper.error, (each.chosen.high - each.chosen.low) / 2 / truth)
        if each
        else (np.nan, np.nan, np.nan)
        for each in of
    ]
    chosen, paper, reach = np.abs(np.array(rows, dtype=np.float64).reshape(-1, 3).T)
    return _Errors(name, chosen, paper, reach)


def _step(after: _Errors, before: _Errors, angles_deg: Sequence[float]) -> str:
    both = np.isfinite(after.chosen) & np.isfinite(before.chosen)
    if not both.any():
        return ""
    counted, sizes = _counted(after.chosen[both], before.chosen[both])
    name = after.name[0].upper() + after.name[1:]
    first = f"{name} has the smaller error at {counted} ({sizes} with {before.name})"
    return f"{first}{_by_paper(after, before)}. {_settled(after, before, both, angles_deg)}"


def _counted(after: Floats, before: Floats) -> tuple[str, str]:
    """At how many angles ``after`` is smaller, or the same as people see it, and the medians."""
    same = np.array([percent(a) == percent(b) for a, b in zip(after.tolist(), before.tolist(), strict=True)])
    smaller = np.count_nonzero((after < before) & ~same)
    equal = f" and the same at {np.count_nonzero(same)}" if same.any() else ""
    sizes = [percent(float(np.median(each))) for each in (after, before)]
    return f"{smaller} of {count(after.size, 'angle')}{equal}", f"median {sizes[0]} against {sizes[1]}"


def _by_paper(after: _Errors, before: _Errors) -> str:
    """The same by the paper's law; "" where that was chosen."""
    both = np.isfinite(after.paper) & np.isfinite(before.paper)
    errors = np.stack([after.paper, before.paper])[:, both]
    if not both.any() or np.array_equal(errors, np.stack([after.chosen, before.chosen])[:, both]):
        return ""
    counted, sizes = _counted(*errors)
    return f", by the paper's law at {counted} ({sizes})"


def _settled(after: _Errors, before: _Errors, both: np.ndarray, angles_deg: Sequence[float]) -> str:
    """At how many angles the order can be told, and why not at the others."""
    gap, paper_gap = after.chosen - before.chosen, after.paper - before.paper
    disagree = both & (np.sign(gap) * np.sign(paper_gap) < 0)
    closed = np.isfinite(after.reach) & np.isfinite(before.reach)
    close = both & closed & ~(np.abs(gap) > after.reach + before.reach)
    why = [
        (
            f"{each.name} leaves κ undetermined at {{}} (interval without an upper end, or none)",
            ~np.isfinite(each.reach),
        )
        for each in (before, after)
    ] + [
        ("the two laws disagree at {}", disagree),
        ("the errors differ by less than the intervals reach at {}", close),
    ]
    said = [
        words.format(listed([f"{angle:g}°" for angle, there in zip(angles_deg, both & where, strict=True) if there]))
        for words, where in why
        if (both & where).any()
    ]
    n = np.count_nonzero(both & closed & ~disagree & ~close)
    reasons = f": {'; '.join(said)}" if said else ""
    return f"The order is settled at {n} of {count(int(np.count_nonzero(both)), 'angle')}{reasons}."


def _intervals(found: CalibrationResults, algorithm: str) -> str:
    of = [each.algorithms[algorithm] for each in found.conditions if algorithm in each.algorithms]
    held = [inside for each in of if (inside := holds(each, found.known_kappa_new)) is not None]
    if not of:
        return ""
    endless = sum(bool(np.isinf(each.chosen.high)) for each in of)
    said = f"By {algorithm}, the interval holds the known stiffness in {sum(held)} of {count(len(held), 'design')}"
    said += f" ({endless} without an upper end)" if endless else ""
    missing = len(of) - len(held)
    return f"{said}; {count(missing, 'more design')} {_have(missing)} an undefined interval." if missing else f"{said}."


def _have(n: int) -> str:
    return "has" if n == 1 else "have"


def _caution(found: CalibrationResults, algorithm: str) -> str:
    """An error is one draw: how wide the intervals are beside it."""
    chosen = [each.algorithms[algorithm].chosen for each in found.conditions if algorithm in each.algorithms]
    widths = [(of.high - of.low) / 2 / of.kappa for of in chosen if np.isfinite([of.low, of.high, of.kappa]).all()]
    wide = (
        f"presses leave κ by {algorithm} uncertain by ± {percent(float(np.median(widths)))} in the median of "
        f"{count(len(widths), 'closed interval')}"
        if widths
        else f"no interval by {algorithm} is closed"
    )
    return (
        f"An error is one draw: {wide}. An order is called settled where both laws agree on it, both intervals are "
        "closed, and the errors differ by more than half the widths of both together."
    )
