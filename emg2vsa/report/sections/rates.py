"""The contact area spread rate: does it tell the specimens apart, and the new one from its neighbours?

And CASR as the paper's printed curves imply it, beside what contact mechanics allows.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise

import numpy as np

from emg2vsa.arrays import Floats, mean_of
from emg2vsa.claims import paper
from emg2vsa.discrimination import Discrimination
from emg2vsa.discrimination.run_table import HUMAN_LIKE, RIGID
from emg2vsa.figures.casr import RateSeries, draw_rates
from emg2vsa.figures.palette import Look
from emg2vsa.report.companion_rows import dunn_bounds
from emg2vsa.report.designs import (
    BOXES,
    BY_PRESSES,
    DESIGN,
    design_name,
    design_names,
    drawing,
    ends_of,
    finite,
    keys,
    looks,
    medians_said,
    of_tests,
    ranks_of,
    tested,
)
from emg2vsa.report.drawing import Drawing
from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.numbers import Items, fields_of, moments, with_interval
from emg2vsa.report.section import Quantities, Section, of_runs
from emg2vsa.report.table import Column, Columns, Table, table_of
from emg2vsa.report.wording import UNDEFINED, area_unit, bounded, exact_p, interval, listed, p_value, scored_by
from emg2vsa.run_scores import PressCurve
from emg2vsa.statistics.kruskal import smallest_worst_p

_RAW = (
    "Left: raw dA/dF from frame to frame of all presses, a part of them, and its fit, the derivative of {law} through "
    "the areas. Right: CASR of the presses."
)
_LAW = {"ode": "a power law", "paper": "equation (1)"}


def _quantities(results: StudyResults) -> Items:
    for (condition, angle), p in paper.CASR_WORST_P.items():
        yield f"paper.{condition}.{angle:g}.casr.worst_p", p
    yield "paper.constant-min.0.new.stiffer_mean_rank_p", paper.NEW_MIN_STIFFNESS_P
    found = tested(results)
    table, spread, new = found.table, found.spread, found.new
    for i, name in enumerate(keys(found)):
        yield from ranks_of(f"{name}.casr", spread.kruskal, i)
        yield f"{name}.casr.worst_p", float(spread.worst_p[i])
        for k, (stiffer, softer) in enumerate(pairwise(table.specimens)):
            at = i * (len(table.specimens) - 1) + k
            yield from with_interval(f"{name}.casr.{softer}_over_{stiffer}", *ends_of(spread.steps, at))
        if not table.unscored(i, spread.specimens):
            yield f"{name}.casr.rises", bool(spread.rises[i])
        for specimen, values in zip(table.specimens, table.casr[table.algorithm][i], strict=True):
            yield from moments(f"{name}.{specimen}.casr_{table.area_unit}_per_n", values)
        if new is not None:
            for side, neighbour in enumerate(("stiffer", "softer")):
                yield f"{name}.new.{neighbour}_mean_rank_p", float(new.p_mean_rank[i, side])
            yield from fields_of(f"{name}.new", new, "between", "discriminated", at=i)
    if new is not None:
        yield "runs.new.specimen", new.name
        yield "runs.new.discriminated", int(np.count_nonzero(new.discriminated))
        yield "runs.new.designs", int(new.discriminated.size)


def _tables(results: StudyResults, q: Quantities) -> Iterator[Table]:
    found = tested(results)
    yield _by_specimen(found)
    yield _steps(found)
    if found.new is not None:
        yield _new(found)


def _by_specimen(found: Discrimination) -> Table:
    table, spread, unit = found.table, found.spread, found.table.area_unit
    designs = zip(table.conditions, table.angles_deg.tolist(), strict=True)
    means = zip(spread.specimens, spread.mean.T, strict=True)
    rises = [None if table.unscored(i, spread.specimens) else bool(each) for i, each in enumerate(spread.rises)]
    columns: Columns = {
        DESIGN: design_names(table),
        **{Column(f"{name}_{unit}_per_n", f"{name} ({area_unit(unit)}/N)"): mean for name, mean in means},
        Column("rises", "Softer is larger"): rises,
        Column("p", "Kruskal-Wallis p"): spread.kruskal.p,
        Column("worst_paper", "Paper's worst p (Dunn, Bonferroni)"): [
            exact_p(paper.CASR_WORST_P.get(design, np.nan)) for design in designs
        ],
        Column("worst_dunn", "Worst p here (Dunn, Bonferroni)"): list(map(p_value, spread.worst_p.tolist())),
    }
    return table_of("casr_by_specimen", f"Mean CASR by specimen, and the paper's tests. {BY_PRESSES}", columns)


def _steps(found: Discrimination) -> Table:
    """From every specimen to the next softer one, the new one in its place."""
    table, steps = found.table, found.spread.steps
    pairs = list(pairwise(table.specimens))
    columns: Columns = {
        DESIGN: design_names(table),
        **{
            Column(f"{softer}_over_{stiffer}", f"{softer} / {stiffer}"): [
                interval(*ends_of(steps, i * len(pairs) + k)) for i in range(len(table.conditions))
            ]
            for k, (stiffer, softer) in enumerate(pairs)
        },
    }
    level = f"{100 * (1 - found.settings.alpha):g} %"
    return table_of(
        "casr_steps", f"CASR over that of the next stiffer specimen, {level} interval over mountings", columns
    )


def _new(found: Discrimination) -> Table:
    new, table = found.new, found.table
    assert new is not None
    designs = zip(table.conditions, table.angles_deg.tolist(), strict=True)
    scored = [
        not table.unscored(i, [name for name in (*new.neighbours, new.name) if name]) for i in range(len(new.between))
    ]
    between, apart = (
        [value if k else None for value, k in zip(each.tolist(), scored, strict=True)]
        for each in (new.between, new.discriminated)
    )
    columns: Columns = {
        DESIGN: design_names(table),
        Column("paper", "Paper (Dunn, Bonferroni)"): [_paper_new(*design) for design in designs],
        **{
            Column(f"p_rank_{side}", f"p against {name or 'none'} (Dunn, Bonferroni)"): new.p_mean_rank[:, i]
            for i, (side, name) in enumerate(zip(("stiffer", "softer"), new.neighbours, strict=True))
        },
        Column("between", "Lies between"): between,
        Column("discriminated", "Both intervals say so"): apart,
    }
    return table_of("new_specimen", f"{new.name} beside its neighbours in stiffness. {BY_PRESSES}", columns)


def _paper_new(condition: str, angle_deg: float) -> str:
    if (condition, angle_deg) not in paper.DESIGNS:
        return UNDEFINED
    least = condition == "constant-min"
    return f"not told apart, p = {exact_p(paper.NEW_MIN_STIFFNESS_P)}" if least else "told apart"


def _drawings(results: StudyResults) -> Iterator[Drawing]:
    table, look = tested(results).table, looks(results)
    # lowest, highest and mean level, as the paper has them
    constant = [i for level in ("min", "max", "mean") for i in table.of_condition(f"constant-{level}")]
    for name, number, what, designs in (
        ("fig10_rigid", 10, "rigid motor (high stiffness)", table.of_condition(RIGID)),
        ("fig12_human_like", 12, "human-like stiffness (modular)", table.of_condition(HUMAN_LIKE)),
        ("fig13_constant", 13, "constant levels of the profile", constant),
    ):
        if not designs:
            continue
        rows = [(design_name(table, i), _series(results, look, i)) for i in designs]
        specimens = listed(list(dict.fromkeys(each.name for _, row in rows for each in row)))
        unit = area_unit(table.area_unit)
        told = medians_said([(title, [(each.name, each.casr) for each in row]) for title, row in rows])
        caption = (
            f"Fig. {number}. CASR of {specimens}, {what}. All panels by {scored_by(results.study.scoring)}. "
            f"{_RAW.format(law=_LAW[results.study.scoring.recipe.law])} {_without(rows)}{BOXES}"
        )
        said, figure = f"Median CASR in {unit}/N. {told}.", draw_rates(rows, unit)
        yield drawing(results, name, f"dA/dF against force and CASR, {what}", caption, said, figure)


def _without(rows: Sequence[tuple[str, Sequence[RateSeries]]]) -> str:
    """Which specimens have no mark, as a sentence; "" where all have."""
    lacking = [
        f"{title}: {listed(names)}" for title, row in rows if (names := [s.name for s in row if not s.casr.size])
    ]
    return f"No press has a CASR in {'; '.join(lacking)} (see the notes about the runs). " if lacking else ""


def _series(results: StudyResults, look: Mapping[str, Look], design: int) -> Sequence[RateSeries]:
    table = tested(results).table
    of = (table.conditions[design], float(table.angles_deg[design]))
    runs = {run.specimen: run for run in results.pressed.scores if (run.condition, run.angle_deg) == of}
    recipe = results.study.scoring.recipe
    series = []
    for specimen, scores in zip(table.specimens, table.casr[table.algorithm][design], strict=True):
        if specimen in runs:
            presses = [_points(curve, recipe.rate == "paper") for curve in runs[specimen].curves]
            series.append(RateSeries(specimen, look[specimen], presses, finite(scores), recipe.law == "paper"))
    return series


def _points(curve: PressCurve, as_printed: bool) -> tuple[Floats, Floats]:
    """Forces and areas of a press; the first force is 0 in equation (2) as printed."""
    force_n = curve.force_n.copy()
    force_n[:1] = 0.0 if as_printed else force_n[:1]
    return force_n, curve.area_mm2


def _words(results: StudyResults, q: Quantities) -> dict[str, object]:
    found = tested(results)
    count = np.isfinite(found.table.casr[found.table.algorithm]).sum(axis=2)
    every, known = dunn_bounds(count[0]), dunn_bounds(count[0][found.table.known])
    uncorrected, corrected = smallest_worst_p(*_PAPERS_PRESSES)
    printed = list(paper.CASR_WORST_P.values())
    return {
        "notes": found.notes,
        "new": found.new.name if found.new else "",
        "bound": p_value(known[1]) if known else "",
        "papers_bounds": (bounded(corrected), bounded(uncorrected, 4)),
        "below": sum(p < uncorrected - _ROUNDED for p in printed),
        "printed": len(printed),
        "new_bound": p_value(every[1]) if every and every[1] >= found.settings.alpha else "",
    }


_PAPERS_PRESSES = 3, 10
"""Known specimens, and presses of each."""
_ROUNDED = 5e-5

_TEXT = """
<p>{% if bound %}The paper's test cannot give neighbours a p below {{ bound }} here, even if they do not overlap.
{% endif %}On ten presses of each of three specimens its least p is {{ papers_bounds[0] }}, or {{ papers_bounds[1] }}
without the correction. {{ below }} of the {{ printed }} p that the paper prints are smaller still: this test cannot
give them on so many presses, corrected or not.</p>
{{ folded("casr_steps", "CASR from specimen to specimen, over mountings") }}
{{ folded("casr_by_specimen", "CASR in every design") }}
{% if new %}
<h3>Is {{ new }} told from its neighbours?</h3>
<p>The paper's test ranks all specimens together.{% if new_bound %} Its smallest p for neighbours is
{{ new_bound }}.{% endif %}</p>
{{ folded("new_specimen", new ~ " and its neighbours in every design") }}
{% endif %}
{{ folded("fig10_rigid", "Figure 10: CASR with the rigid motor") }}
{{ folded("fig12_human_like", "Figure 12: CASR with human-like stiffness") }}
{{ folded("fig13_constant", "Figure 13: CASR with constant stiffness") }}
{% if notes %}<details><summary>Notes on the tests</summary>{{ notes | bullets }}</details>{% endif %}
"""

RATES = Section("casr", "Contact area spread rate", _TEXT, of_tests, _quantities, _tables, _drawings, _words)

_STIFFEST, *_, _SOFTEST = paper.KAPPA_N_PER_MM


def _implied_quantities(results: StudyResults) -> Items:
    for angle in paper.CURVES:
        for name, kappa in paper.KAPPA_N_PER_MM.items():
            yield f"paper.modular.{angle:g}.casr_implied.{name}", paper.implied_casr(angle, kappa)
        yield f"paper.modular.{angle:g}.casr_implied.ratio", paper.implied_ratio(angle)
    yield "paper.casr_ratio_bound", paper.largest_ratio()


def _implied_tables(results: StudyResults, q: Quantities) -> Iterator[Table]:
    columns: Columns = {
        Column("angle_deg", "Angle (°)", digits=2): list(paper.CURVES),
        Column("curve", "κ (N/mm) as printed"): [f"{p:g} exp({rate:g} CASR)" for p, rate in paper.CURVES.values()],
        **{
            Column(f"casr_{name}", f"{name}, {kappa:g} N/mm"): [paper.implied_casr(a, kappa) for a in paper.CURVES]
            for name, kappa in paper.KAPPA_N_PER_MM.items()
        },
        Column("ratio", f"{_SOFTEST} : {_STIFFEST} implied"): list(map(paper.implied_ratio, paper.CURVES)),
        Column("bound", "Largest possible", digits=2): [paper.largest_ratio()] * len(paper.CURVES),
        Column("here", f"{_SOFTEST} : {_STIFFEST} here"): [_ratio_here(results, angle) for angle in paper.CURVES],
    }
    caption = "CASR of each specimen at which the paper's curves give its stiffness (unit not printed)"
    yield table_of("casr_implied", caption, columns)


def _ratio_here(results: StudyResults, angle_deg: float) -> float:
    """Mean CASR of the softest over that of the stiffest of the paper's specimens; NaN where one was not pressed."""
    if not of_tests(results):
        return np.nan
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


def _implied_words(results: StudyResults, q: Quantities) -> dict[str, object]:
    first, *_, last = paper.CURVES
    falls = [
        paper.implied_casr(first, kappa) / paper.implied_casr(last, kappa) for kappa in paper.KAPPA_N_PER_MM.values()
    ]
    whole_image = of_tests(results) and results.study.scoring.recipe.region == "image"
    fall_here = _fall_here(results, first, last) if whole_image else None
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


_IMPLIED_TEXT = """
<p>Whatever the unit of CASR, Hertz's contact bounds the ratio of the
softest to the stiffest specimen, and a sensor that yields makes it smaller.</p>
{{ folded("casr_implied", "CASR that the paper's curves imply") }}
<p>From {{ first | number(1) }}° to {{ last | number(2) }}° the implied CASR falls {{ least_fall | number(2) }} to
{{ largest_fall | number(2) }} times, which no unit explains. A divergence averaged over the whole image could be so
small. That is a hypothesis, which <code>region = "image"</code> tests{% if fall_here %}; here CASR over the whole image
falls {{ fall_here | number(2) }} times (mean of the specimens){% endif %}.</p>
"""

IMPLIED = Section(
    "implied",
    "What the paper's curves imply",
    _IMPLIED_TEXT,
    of_runs,
    _implied_quantities,
    _implied_tables,
    words=_implied_words,
)
