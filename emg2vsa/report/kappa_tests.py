"""The paper's own numbers on kappa, as it made them: an exponential law, least squares of kappa, no interval."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from emg2vsa.claims import paper
from emg2vsa.claims.kappa import DESIGNS, NEW, STEPS, Design
from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.section import PaperTest, Quantities
from emg2vsa.report.wording import NO_BREAK, UNDEFINED, bounded, number, signed

_PRINTED = {
    "rigid": list(paper.ERROR_NEW_VISION.values()),
    "human_like": list(paper.ERROR_HUMAN_LIKE.values()),
    "constant": list(paper.ERROR_CONSTANT.values()),
}
_CUTS = {"vision": "18, 15 points", "human_like": "4, 9 points", "both": f"3 (50{NO_BREAK}%), 22, 24 points"}


def kappa_tests(results: StudyResults, q: Quantities) -> dict[str, PaperTest]:
    """By the key of the claim."""
    how = "exponential law, hexagons" if results.study.scoring.recipe_of(NEW).area_rule == NEW else "exponential law"
    found = {}
    for key, (_, designs) in DESIGNS.items():
        least = min(paper.WORST_ADJ_R2[condition] for condition, _ in designs)
        r2, slope, error = (_laws(q, designs, NEW, name) for name in ("adj_r2", "parameter.second", "error"))
        rising = int(np.count_nonzero(slope > 0))
        fit = f"adj. R² ≥ {bounded(float(r2.min()))}, {how}" if np.isfinite(r2).all() else UNDEFINED
        found[f"kappa_fit_{key}"] = PaperTest(
            f"adj. R² ≥ {bounded(least, 4)}", f"{fit}; κ rises with CASR in {rising} of {slope.size}" if rising else fit
        )
        printed = ", ".join(number(100 * each, 2) for each in _PRINTED[key])
        here = f"{', '.join(signed(100 * each) for each in error.tolist())}{NO_BREAK}%, {how}"
        found[f"kappa_error_{key}"] = PaperTest(
            f"{printed}{NO_BREAK}%", here + _undetermined(q, designs) if np.isfinite(error).all() else UNDEFINED
        )
    for key, step in STEPS.items():
        before, after = (
            np.abs(_laws(q, [(condition, angle) for angle in step.angles_deg], name or NEW, "error"))
            for condition, name in (step.before, step.after)
        )
        cut = 100 * (before - after)
        points = f"{', '.join(signed(each) for each in cut.tolist())} points, {how}"
        found[f"reduction_{key}"] = PaperTest(_CUTS[key], points if np.isfinite(cut).all() else UNDEFINED)
    return found


def _laws(q: Quantities, designs: Sequence[Design], algorithm: str, key: str) -> np.ndarray:
    """A number of the paper's law in each design; NaN where it is absent."""
    return np.array([float(q.get(f"runs.{c}.{a:g}.{algorithm}.kappa.paper_law.{key}", np.nan)) for c, a in designs])


def _undetermined(q: Quantities, designs: Sequence[Design]) -> str:
    told = int(np.nansum(_laws(q, designs, NEW, "determined")))
    return "" if told == len(designs) else f"; κ determined in {told} of {len(designs)}"
