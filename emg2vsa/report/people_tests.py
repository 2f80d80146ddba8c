"""The paper's own tests of its claims on people, as it ran them: printed numbers, and what they say here."""

from __future__ import annotations

import numpy as np

from emg2vsa.claims import paper
from emg2vsa.hypotheses import Hypotheses
from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.section import PaperTest, Quantities
from emg2vsa.report.wording import activity, bounded, p_text


def people_tests(results: StudyResults, q: Quantities) -> dict[str, PaperTest]:
    """The paper's tests on people, by the key of the claim; none without fits of people."""
    if results.people is None:
        return {}
    of_tests = _tests(results.people.hypotheses, q) if results.people.hypotheses else {}
    r2, profiles, rmse = float(q["fit.adj_r2_samples.min"]), results.people.profiles, ""
    if profiles is not None and profiles.new_error is not None:
        error = activity(profiles.new_error.rmse_v, results.scale)
        rmse = f"RMSE {error}, {profiles.participant or 'all participants'}"
    return of_tests | {
        "log_fit_r2": PaperTest("adj. R² ≥ .832", f"adj. R² on samples ≥ {bounded(r2)}" if r2 == r2 else ""),
        "interpolation_rmse": PaperTest(f"RMSE {paper.INTERPOLATION_RMSE_V:g} V", rmse),
    }


def _tests(found: Hypotheses, q: Quantities) -> dict[str, PaperTest]:
    def count(tests: str, name: str, did: str) -> str:
        """``One-way ANOVA: 1 of 5 differ``."""
        significant, tested = (q[f"hypotheses.{tests}.{key}"] for key in ("significant", "tested"))
        return f"{name}: {significant} of {tested} {did}" if tested else ""

    pairs, others = found.tests.pairs, ~np.isin(found.specimens, found.kept)
    p = pairs.lsd.p[:, others[pairs.first] | others[pairs.second]] if others.size > 1 else np.empty(0)
    same, tested = np.count_nonzero(p >= found.alpha), np.count_nonzero(np.isfinite(p))
    worst = f"Fisher's LSD: largest {p_text(found.worst_p)}, of {found.worst_pair}" if found.worst_pair else ""
    distinct = f"Fisher's LSD: {same} of {tested} pairs with p ≥ {found.alpha:g}" if tested else ""
    normality = count("normality.standardised", "Kolmogorov-Smirnov, standardised", "deviate")
    return {
        "specimens_differ": PaperTest("largest p = .0391", worst),
        "others_not_distinct": PaperTest("no number", distinct),
        "gaussian_clusters": PaperTest("0 of 70 deviate", normality),
        "equal_participants": PaperTest("0 of 5 differ", count("between_participants", "One-way ANOVA", "differ")),
    }
