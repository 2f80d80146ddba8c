"""The whole curve: do specimens differ at each force, whatever the law of force?"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from emg2vsa.companions.whole_curve import WholeCurve
from emg2vsa.figures.palette import looks
from emg2vsa.figures.whole_curve import draw_whole_curve
from emg2vsa.report.drawing import Drawing
from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.numbers import Items, fields_of, least, most, with_interval
from emg2vsa.report.section import Quantities, Section, of_people
from emg2vsa.report.table import Table, activity_column, columns, table_of
from emg2vsa.report.wording import listed, number, percent
from emg2vsa.statistics.whole_curve import FEWEST_FOR_BANDS


def _found(results: StudyResults) -> WholeCurve | None:
    """Where curves were compared."""
    tested = results.recorded.hypotheses
    return tested.curves if tested is not None and not tested.curves.tests.why else None


def _quantities(results: StudyResults) -> Items:
    if (found := _found(results)) is None:
        return
    tests, every = found.tests, found.by_force()
    yield "curves.people", found.participants.size
    yield "curves.forces", found.from_n.size
    yield "curves.from_n", float(found.from_n[0])
    yield "curves.to_n", float(found.to_n[-1])
    yield from fields_of("curves", tests, "alpha", "draws")
    for name, of in (("all", tests.f_threshold), ("pairs", tests.t_threshold)):
        yield from with_interval(f"curves.{name}.threshold", of.value, of.low, of.high)
    names = ["all", *(f"pairs.{'-'.join(pair)}" for pair in found.pairs)]
    for pair, (name, share) in enumerate(zip(names, found.differing().tolist(), strict=True), -1):
        yield f"curves.{name}.largest_{'f' if pair < 0 else 't'}", most(np.abs(every.statistic[every.pair == pair]))
        yield f"curves.{name}.p", least(every.p[every.pair == pair])
        yield f"curves.{name}.differ_percent", 100 * share


def _tables(results: StudyResults, q: Quantities) -> Iterator[Table]:
    if (found := _found(results)) is None:
        return
    ranges = (
        "Ranges of force in which specimens differ. Difference, interval and p are those at the force of the largest F "
        "or t in the range; they hold at all forces and pairs together, of people who are independent"
    )
    by_force = "By force: F of all specimens, t and difference of each pair, mean of each specimen"
    for name, caption, rows in (
        ("whole_curve", ranges, found.ranges()),
        ("curves_by_force", by_force, found.by_force()),
    ):
        heads = {"value_v": "Difference, or mean", "low_v": "Low", "high_v": "High"}
        values = {activity_column(key, head, results.scale): getattr(rows, key[:-2]) for key, head in heads.items()}
        yield table_of(name, caption, columns(rows, "of", "from_n", "to_n", "statistic", "p") | values)


_ALL_PAIRS_UP_TO = 5


def _drawings(results: StudyResults) -> Iterator[Drawing]:
    if (found := _found(results)) is None:
        return
    neighbours = found.neighbours(results.study.stiffness_n_per_mm)
    others = [i for i in range(len(found.pairs)) if i not in neighbours]
    drawn = neighbours + others * (found.specimens.size <= _ALL_PAIRS_UP_TO)
    figure = draw_whole_curve(found, drawn, neighbours, looks(results.specimens), results.scale)
    banded = np.isfinite(found.tests.half_width).any()
    bands = (
        ", with simultaneous bands about the mean of the specimens"
        if banded
        else f"; bands need {FEWEST_FOR_BANDS} people"
    )
    caption = (
        f"Fig. W. (a) Mean over people{bands}. (b) F between specimens; dashed: threshold. (c) Forces at which "
        "pairs differ; blue: neighbours."
    )
    description = (
        f"Of the forces from {number(found.from_n[0])} to {number(found.to_n[-1])} N, all specimens differ at "
        f"{percent(found.differing()[0], 2)}; pairs: {'; '.join(_told(found, drawn))} of them."
    )
    yield Drawing("curves", "Whole curves of co-contraction against force", caption, description, figure)


def _told(found: WholeCurve, pairs: list[int]) -> list[str]:
    """``S1–S2 at 100 %`` of each pair that differs at some forces."""
    share = found.differing()
    named = [("–".join(found.pairs[pair]), share[pair + 1]) for pair in pairs]
    return [f"{name} at {percent(of, 2)}" for name, of in named if of] or ["none at any"]


def _words(results: StudyResults, q: Quantities) -> dict[str, object]:
    if (found := _found(results)) is None:
        return {"why": tested.curves.tests.why if (tested := results.recorded.hypotheses) else ""}
    told = _told(found, found.neighbours(results.study.stiffness_n_per_mm))
    return {"differ": listed(told), "left_out": listed(found.left_out)}


_TEXT = """
{% if differ is not defined %}
<p>{% if why %}The curves were not compared: {{ why }}.{% else %}{{ why_absent("hypotheses") }}{% endif %}</p>
{% else %}
{{ figure("curves") }}
<p>One test compares {{ q['curves.people'] }} people at {{ q['curves.forces'] }} forces, without a law of force.
Of neighbours in stiffness differ: {{ differ }} of the forces.
{% if left_out %}Left out, for lack of data: {{ left_out }}.{% endif %}</p>
{{ folded("whole_curve", "Ranges of force in which specimens differ") }}
{{ folded("curves_by_force", "Curves, differences and statistics by force") }}
{% endif %}
"""

CURVES = Section("curves", "The whole curve", _TEXT, of_people, _quantities, _tables, _drawings, _words)
