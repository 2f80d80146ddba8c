"""The paper's own tests of its claims on the rig's presses: what it prints, and what its tests say here.

Its rank tests take presses of one mounting as independent, on the scores of the algorithm that the study tests. Its
stiffness is that of an exponential law by least squares of kappa, without an interval.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

import numpy as np

from emg2vsa.claims import kappa, paper
from emg2vsa.claims.kappa import NEW, STEPS, Design
from emg2vsa.claims.rig import CONSTANT, designs_of
from emg2vsa.discrimination.run_table import HUMAN_LIKE, RIGID
from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.section import PaperTest, Quantities
from emg2vsa.report.wording import NO_BREAK, UNDEFINED, bounded, exact_p, number, p_text, signed

_PRINTED: dict[str, Mapping[Any, float]] = {
    "rigid": paper.ERROR_NEW_VISION, "human_like": paper.ERROR_HUMAN_LIKE, "constant": paper.ERROR_CONSTANT,
}  # fmt: skip
_CUTS = {"vision": "18, 15 points", "human_like": "4, 9 points", "both": f"3 (50{NO_BREAK}%), 22, 24 points"}


def rig_tests(results: StudyResults, q: Quantities) -> dict[str, PaperTest]:
    """The paper's tests on the rig, by the key of the claim; only claims that the paper tests."""
    found = results.runs.discrimination if results.runs else None
    tests = {} if found is None else dict(_by_ranks(q, f", by {found.table.algorithm}"))
    hexagons = results.study.scoring.recipe_of(NEW).area_rule == NEW
    return tests | dict(_of_kappa(q, "exponential law of CASR, hexagons" if hexagons else "exponential law of CASR"))


def _by_ranks(q: Quantities, by: str) -> Iterator[tuple[str, PaperTest]]:
    """by : the algorithm, in words."""

    def said(test: str, p: np.ndarray) -> str:
        return UNDEFINED if np.isnan(p).any() else f"{test}{p_text(float(p.max()))}{by}"

    same = _of(q, (f"runs.{RIGID}.{angle:g}.area.specimens_p" for angle in paper.AREA_SPECIMENS_P))
    printed = ", ".join(bounded(p, 2) for p in paper.AREA_SPECIMENS_P.values())
    yield "area_same_on_specimens", PaperTest(f"p = {printed}", said("Kruskal-Wallis, least ", same.min(keepdims=True)))
    angles = said("Dunn, worst ", _of(q, [f"runs.{RIGID}.area.angles.worst_p"]))
    yield "area_changes_with_angle", PaperTest(f"worst p = {_power(paper.AREA_ANGLES_WORST_P)}", angles)
    new = _of(q, (f"runs.{level}.0.new.{side}_mean_rank_p" for level in CONSTANT for side in ("stiffer", "softer")))
    yield "fig13_new_specimen", PaperTest("told apart", said("Dunn, worst ", new[2:]))
    yield "new_specimen_at_minimum", PaperTest(f"p = {exact_p(paper.NEW_MIN_STIFFNESS_P)}", said("Dunn, ", new[:1]))
    yield "human_like_contrast", PaperTest("better than rigid and constant")
    yield "constant_levels", PaperTest("better than 3 of 3 levels")
    for key, conditions in (("rigid", (RIGID,)), ("human_like", (HUMAN_LIKE,)), ("constant", CONSTANT)):
        designs = designs_of(*conditions)
        worst = _of(q, (f"runs.{condition}.{angle:g}.casr.worst_p" for condition, angle in designs))
        of_paper = dict.fromkeys(exact_p(paper.CASR_WORST_P[design]) for design in designs)
        yield f"casr_{key}", PaperTest(f"worst p = {', '.join(of_paper)}", said("Dunn, worst ", worst))
    for figure, condition in ((10, RIGID), (12, HUMAN_LIKE)):
        names = [f"runs.{condition}.{angle:g}" for _, angle in designs_of(condition)]
        rises = [(q.get(f"{name}.casr.rises"), q.get(f"{name}.new.between")) for name in names]
        known = [all(each) for each in rises if None not in each]
        here = f"order of means in {sum(known)} of {len(known)} angles{by}" if known else UNDEFINED
        yield f"fig{figure}_order", PaperTest(f"{len(names)} of {len(names)} angles", here)


def _of_kappa(q: Quantities, how: str) -> Iterator[tuple[str, PaperTest]]:
    """how : the law and the algorithm, in words."""
    for key, (_, designs) in kappa.DESIGNS.items():
        least = min(paper.WORST_ADJ_R2[condition] for condition, _ in designs)
        r2, slope, error, told = (
            _laws(q, designs, NEW, name) for name in ("adj_r2", "parameter.second", "error", "determined")
        )
        rising = int(np.count_nonzero(slope > 0))
        fit = f"adj. R² ≥ {bounded(float(r2.min()))}, {how}" if np.isfinite(r2).all() else UNDEFINED
        fit += f"; κ rises with CASR in {rising} of {slope.size}" if rising else ""
        yield f"kappa_fit_{key}", PaperTest(f"adj. R² ≥ {bounded(least, 4)}", fit)
        printed = ", ".join(number(100 * each, 2) for each in _PRINTED[key].values())
        here = f"{', '.join(signed(100 * each) for each in error.tolist())}{NO_BREAK}%, {how}"
        if (determined := int(np.nansum(told))) < len(designs):
            here += f"; κ determined in {determined} of {len(designs)}"
        here = here if np.isfinite(error).all() else UNDEFINED
        yield f"kappa_error_{key}", PaperTest(f"{printed}{NO_BREAK}%", here)
    for key, step in STEPS.items():
        before, after = (
            np.abs(_laws(q, [(condition, angle) for angle in step.angles_deg], name or NEW, "error"))
            for condition, name in (step.before, step.after)
        )
        cut = 100 * (before - after)
        points = f"{', '.join(signed(each) for each in cut.tolist())} points, {how}"
        yield f"reduction_{key}", PaperTest(_CUTS[key], points if np.isfinite(cut).all() else UNDEFINED)


def _laws(q: Quantities, designs: Iterable[Design], algorithm: str, key: str) -> np.ndarray:
    """A number of the paper's law in each design; NaN where it is absent."""
    return _of(q, (f"runs.{c}.{a:g}.{algorithm}.kappa.paper_law.{key}" for c, a in designs))


def _of(q: Quantities, keys: Iterable[str]) -> np.ndarray:
    """The numbers under ``keys``, NaN for those that are absent."""
    return np.array([float(q.get(key, np.nan)) for key in keys])


def _power(value: float) -> str:
    """``3.1 × 10⁻⁵``, as the paper prints it."""
    exponent = int(np.floor(np.log10(value)))
    superscript = str(exponent).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
    return f"{value / 10.0**exponent:.1f}{NO_BREAK}×{NO_BREAK}10{superscript}"
