"""CASR as the paper's printed curves imply it, beside what contact mechanics allows."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from emg2vsa.calibration.presses import mean_of
from emg2vsa.discrimination.run_table import HUMAN_LIKE
from emg2vsa.report import paper
from emg2vsa.report.designs import of_kappa, tested
from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.numbers import Items
from emg2vsa.report.section import Quantities, Section
from emg2vsa.report.table import Column, Row, Table

_STIFFEST, *_, _SOFTEST = paper.KAPPA_N_PER_MM


def _quantities(results: StudyResults) -> Items:
    for angle in paper.CURVES:
        for name, kappa in paper.KAPPA_N_PER_MM.items():
            yield f"paper.modular.{angle:g}.casr_implied.{name}", paper.implied_casr(angle, kappa)
        yield f"paper.modular.{angle:g}.casr_implied.ratio", paper.implied_ratio(angle)
    yield "paper.casr_ratio_bound", paper.largest_ratio()


def _tables(results: StudyResults, q: Quantities) -> Iterator[Table]:
    specimens = paper.KAPPA_N_PER_MM
    columns = (
        Column("angle_deg", "Angle (°)", digits=2), Column("curve", "κ (N/mm) as printed"),
        *(Column(f"casr_{name}", f"{name}, {kappa:g} N/mm") for name, kappa in specimens.items()),
        Column("ratio", f"{_SOFTEST} : {_STIFFEST} implied"), Column("bound", "Largest possible", digits=2),
        Column("here", f"{_SOFTEST} : {_STIFFEST} here"),
    )  # fmt: skip
    rows: tuple[Row, ...] = tuple(
        {
            "angle_deg": angle,
            "curve": f"{level:g} exp({rate:g} CASR)",
            **{f"casr_{name}": paper.implied_casr(angle, kappa) for name, kappa in specimens.items()},
            "ratio": paper.implied_ratio(angle),
            "bound": paper.largest_ratio(),
            "here": _ratio_here(results, angle),
        }
        for angle, (level, rate) in paper.CURVES.items()
    )
    caption = "CASR of each specimen at which the paper's curves give its stiffness (unit not printed)"
    yield Table("casr_implied", caption, columns, rows)


def _ratio_here(results: StudyResults, angle_deg: float) -> float:
    """Mean CASR of the softest over that of the stiffest of the paper's specimens; NaN where one was not pressed."""
    table, ends = tested(results).table, {name: paper.KAPPA_N_PER_MM[name] for name in (_STIFFEST, _SOFTEST)}
    design = table.design(HUMAN_LIKE, angle_deg)
    if (
        design < 0
        or not ends.items() <= results.study.stiffness_n_per_mm.items()
        or not ends.keys() <= {*table.specimens}
    ):
        return np.nan
    scores = table.casr[table.algorithm][design]
    softest, stiffest = (scores[table.specimens.index(name)] for name in (_SOFTEST, _STIFFEST))
    if not (np.isfinite(softest).any() and np.isfinite(stiffest).any()):
        return np.nan
    return float(np.nanmean(softest) / np.nanmean(stiffest))


def _words(results: StudyResults, q: Quantities) -> dict[str, object]:
    first, *_, last = paper.CURVES
    falls = [
        paper.implied_casr(first, kappa) / paper.implied_casr(last, kappa) for kappa in paper.KAPPA_N_PER_MM.values()
    ]
    fall_here = _fall_here(results, first, last) if results.study.scoring.recipe.region == "image" else None
    return {"least_fall": min(falls), "largest_fall": max(falls), "first": first, "last": last, "fall_here": fall_here}


def _fall_here(results: StudyResults, first: float, last: float) -> float | None:
    """Geometric mean, over specimens, of mean CASR at the first angle over that at the last; None without both."""
    table = tested(results).table
    designs = [table.design(HUMAN_LIKE, angle) for angle in (first, last)]
    if min(designs) < 0:
        return None
    means = mean_of(table.casr[table.algorithm][designs])
    falls = means[0] / means[1]
    known = falls[np.isfinite(falls) & (falls > 0)]
    return float(np.exp(np.log(known).mean())) if known.size else None


_TEXT = """
<p>Whatever the unit of CASR, Hertz's contact bounds the ratio of the
softest to the stiffest specimen, and a sensor that yields makes it smaller.</p>
{{ folded("casr_implied", "CASR that the paper's curves imply") }}
<p>From {{ first | number(1) }}° to {{ last | number(2) }}° the implied CASR falls {{ least_fall | number(2) }} to
{{ largest_fall | number(2) }} times, which no unit explains. A divergence averaged over the whole image could be so
small. That is a hypothesis, which <code>region = "image"</code> tests{% if fall_here %}; here CASR over the whole image
falls {{ fall_here | number(2) }} times (mean of the specimens){% endif %}.</p>
"""

IMPLIED = Section("implied", "What the paper's curves imply", _TEXT, of_kappa, _quantities, _tables, words=_words)
