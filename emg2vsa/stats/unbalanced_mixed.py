"""Mixed model of an unbalanced study through statsmodels, with the ways in which it is known to fail told apart."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
from scipy import special
from statsmodels.regression.mixed_linear_model import MixedLM, VCSpec

from emg2vsa.arrays import Floats, exponent_of
from emg2vsa.stats.clusters import Names, in_order
from emg2vsa.stats.outcome import Outcome

METHOD = "linear mixed model, REML by statsmodels"
_SMALL = 1e-8


def unbalanced_mixed(values: Floats, participant: Names, specimen: Names) -> Outcome:
    """b ~ specimen + (1 | participant) + (1 | participant : specimen) of n trials; all arguments (n,), NaN left out.

    The outcome is the Wald F of the specimens, with the df of a balanced study (participants - 1) (specimens - 1), and
    the ICC of participants. Numbers that cannot be trusted are not given: a fit that did not converge, has no finite
    likelihood or ends on a zero variance (where statsmodels is wrong or warns only) yields NaN and a note that says so.
    """
    there = np.isfinite(values)
    values, participant, specimen = values[there], participant[there], specimen[there]
    people, specimens = in_order(participant), in_order(specimen)
    if people.size < 2 or specimens.size < 2 or values.size <= people.size + specimens.size or np.ptp(values) == 0:
        return _without_numbers(
            values.size, "undefined: too few participants, specimens or trials, or all values equal"
        )
    scaled = np.ldexp(values - values[0], -int(exponent_of(values - values[0])[0]))
    design = np.concatenate([np.ones((values.size, 1)), specimen[:, None] == specimens[1:]], axis=1)
    fit, problems = _fit(scaled, design, participant, specimen)
    if fit is None or problems:
        return _without_numbers(values.size, *problems)
    contrast = np.asarray(fit.fe_params)[1:]
    covariance = np.asarray(fit.cov_params())[1 : specimens.size, 1 : specimens.size]
    f = float(contrast @ np.linalg.solve(covariance, contrast)) / contrast.size
    df = (specimens.size - 1.0, (people.size - 1.0) * (specimens.size - 1.0))
    parts = [float(np.ravel(fit.cov_re)[0]), float(fit.vcomp[0]), float(fit.scale)]
    return Outcome(
        method=METHOD,
        n=int(values.size),
        statistic_name="F",
        statistic=f,
        df=df,
        p=float(special.fdtrc(*df, f)),
        effect_name="ICC of participants",
        effect_size=parts[0] / sum(parts),
        notes=("unbalanced: Wald F, df of the balanced study",),
    )


def _fit(y: Floats, design: Floats, participant: Names, specimen: Names) -> tuple[Any, list[str]]:
    """statsmodels' result, or None, and what is wrong with it."""
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        try:
            random = _participant_by_specimen(participant, specimen)
            ones = np.ones((y.size, 1))
            fit = MixedLM(y, design, groups=participant, exog_re=ones, exog_vc=random).fit(reml=True)
        except (np.linalg.LinAlgError, ValueError) as error:
            return None, [f"statsmodels failed: {error}"]
    problems = [] if fit.converged else ["statsmodels did not converge"]
    if not np.isfinite(fit.llf):
        problems.append("statsmodels found no finite likelihood")
    for name, variance in (("participants", np.ravel(fit.cov_re)[0]), ("participants by specimens", fit.vcomp[0])):
        if not variance > _SMALL * fit.scale:
            problems.append(f"variance of {name} at zero, where statsmodels' numbers are not reliable")
    return fit, problems


def _participant_by_specimen(participant: Names, specimen: Names) -> VCSpec:
    """One column per specimen that a participant has pressed, participants in the order statsmodels sorts them."""
    own = [specimen[participant == person] for person in np.unique(participant)]
    columns = [np.unique(pressed) for pressed in own]
    matrices = [(p[:, None] == c).astype(np.float64) for p, c in zip(own, columns, strict=True)]
    return VCSpec(["specimen"], [[c.tolist() for c in columns]], [matrices])


def _without_numbers(n: int, *notes: str) -> Outcome:
    return Outcome(method=METHOD, n=n, statistic_name="F", statistic=float("nan"), p=float("nan"), notes=notes)
