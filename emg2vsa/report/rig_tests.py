"""The paper's own tests of its claims on the rig's presses: what it prints, and what its rank tests say here.

They take presses of one mounting as independent, and the scores of the algorithm that the study tests.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from emg2vsa.claims import paper
from emg2vsa.claims.rig import CONSTANT, designs_of
from emg2vsa.discrimination.run_table import HUMAN_LIKE, RIGID
from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.section import PaperTest, Quantities
from emg2vsa.report.wording import NO_BREAK, UNDEFINED, bounded, exact_p, p_text


def rig_tests(results: StudyResults, q: Quantities) -> dict[str, PaperTest]:
    """By the key of the claim; of claims that the paper tests."""
    found = results.runs.discrimination if results.runs else None
    if found is None:
        return {}
    by = f", by {found.table.algorithm}"
    areas, least = [f"runs.{RIGID}.{angle:g}.area.specimens_p" for angle in paper.AREA_SPECIMENS_P], "worst "
    new = [f"runs.{level}.0.new.{side}_mean_rank_p" for level in CONSTANT for side in ("stiffer", "softer")]
    printed = ", ".join(bounded(p, 2) for p in paper.AREA_SPECIMENS_P.values())
    tests = {
        "area_same_on_specimens": PaperTest(
            f"p = {printed}", _said("Kruskal-Wallis, least ", np.min(_of(q, areas)), by)
        ),
        "area_changes_with_angle": PaperTest(
            f"worst p = {_power(paper.AREA_ANGLES_WORST_P)}",
            _said(f"Dunn, {least}", q.get(f"runs.{RIGID}.area.angles.worst_p"), by),
        ),
        "fig13_new_specimen": PaperTest("told apart", _said(f"Dunn, {least}", np.max(_of(q, new[2:])), by)),
        "new_specimen_at_minimum": PaperTest(
            f"p = {exact_p(paper.NEW_MIN_STIFFNESS_P)}", _said("Dunn, ", q.get(new[0]), by)
        ),
        "human_like_contrast": PaperTest("better than rigid and constant"),
        "constant_levels": PaperTest("better than 3 of 3 levels"),
    }
    for key, conditions in (("rigid", (RIGID,)), ("human_like", (HUMAN_LIKE,)), ("constant", CONSTANT)):
        designs = designs_of(*conditions)
        worst = np.max(_of(q, [f"runs.{condition}.{angle:g}.casr.worst_p" for condition, angle in designs]))
        of_paper = dict.fromkeys(exact_p(paper.CASR_WORST_P[design]) for design in designs)
        tests[f"casr_{key}"] = PaperTest(f"worst p = {', '.join(of_paper)}", _said(f"Dunn, {least}", worst, by))
    for figure, condition in ((10, RIGID), (12, HUMAN_LIKE)):
        names = [f"runs.{condition}.{angle:g}" for _, angle in designs_of(condition)]
        rises = [(q.get(f"{name}.casr.rises"), q.get(f"{name}.new.between")) for name in names]
        known = [all(each) for each in rises if None not in each]
        here = f"order of means in {sum(known)} of {len(known)} angles{by}" if known else UNDEFINED
        tests[f"fig{figure}_order"] = PaperTest(f"{len(names)} of {len(names)} angles", here)
    return tests


def _said(test: str, p: object, by: str) -> str:
    value = float(p) if isinstance(p, float) else np.nan
    return f"{test}{p_text(value)}{by}" if value == value else UNDEFINED


def _of(q: Quantities, keys: Sequence[str]) -> np.ndarray:
    """The numbers under ``keys``, NaN for those that are absent."""
    return np.array([float(q.get(key, np.nan)) for key in keys])


def _power(value: float) -> str:
    """``3.1 × 10⁻⁵``, as the paper prints it."""
    exponent = int(np.floor(np.log10(value)))
    superscript = str(exponent).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
    return f"{value / 10.0**exponent:.1f}{NO_BREAK}×{NO_BREAK}10{superscript}"
