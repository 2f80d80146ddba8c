"""Stiffness of the specimens: what the study file says, and indentations by a flat plate where there are logs."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from emg2vsa.curves.force_range import RangeFit
from emg2vsa.curves.plate_tests import PlateTests, SpecimenPlates
from emg2vsa.curves.specimen_kappa import LEVELS
from emg2vsa.figures.palette import looks
from emg2vsa.figures.plates import draw_plates
from emg2vsa.report.drawing import Drawing
from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.numbers import Items, moments
from emg2vsa.report.section import Quantities, Section
from emg2vsa.report.table import Column, Columns, Table, columns, table_of
from emg2vsa.report.wording import SIMULATED, bounded, count, listed, number
from emg2vsa.shown import words_of


def _quantities(results: StudyResults) -> Items:
    if plates := results.plates:
        yield "plates.simulated", plates.simulated
        for name, worst in plates.worst_adj_r2().items():
            yield f"plates.{name}.adj_r2.min", worst
            yield f"plates.{name}.trials", len(own := plates.of(name))
            if of := plates.specimen(name):
                yield from moments(f"plates.{name}.kappa_n_per_mm", np.array([plates.ranges[i].secant for i in own]))
                yield f"plates.{name}.kappa_n_per_mm.low", of.kappa.mean - of.half
                yield f"plates.{name}.kappa_n_per_mm.high", of.kappa.mean + of.half
                yield f"plates.{name}.mountings", of.kappa.count[1]
                yield f"plates.{name}.from_n", of.range_n[0]
                yield f"plates.{name}.to_n", of.range_n[1]
                yield f"plates.{name}.change", of.change
                yield f"plates.{name}.nonlinear", of.nonlinear
                yield f"plates.{name}.doubtful", sum(plates.ranges[i].rating == "doubtful" for i in own)
                if of.modulus:
                    yield f"plates.{name}.modulus_kpa", of.modulus.mean


def _tables(results: StudyResults, q: Quantities) -> Iterator[Table]:
    study, plates = results.study, results.plates
    stated: Columns = {
        Column("specimen", "Specimen"): results.specimens,
        Column("stiffness_n_per_mm", "κ (N/mm)"): [each.stiffness_n_per_mm for each in study.specimens],
        Column("stiffness_se_n_per_mm", "Standard error", digits=2): [
            each.stiffness_se_n_per_mm or None for each in study.specimens
        ],
        Column("from_n", "From (N)"): [(each.stiffness_range_n or (None, None))[0] for each in study.specimens],
        Column("to_n", "To (N)"): [(each.stiffness_range_n or (None, None))[1] for each in study.specimens],
        Column("plate_adjusted_r2", "Worst adj. R² of a line", digits=4): [
            each.plate_adjusted_r2 for each in study.specimens
        ],
    }
    yield table_of("specimens", "Stiffness of the specimens by plate indentation, as the study file has it", stated)
    if plates:
        own: Columns = {
            Column("specimen", "Specimen"): [each.specimen for each in plates.trials],
            Column("trial", "Trial"): [each.trial for each in plates.trials],
            **{
                Column(key, *head): [getattr(each, key) for each in plates.ranges]
                for key, head in words_of(RangeFit).items()
            },
            **columns(plates.fit, "adj_r2", "n"),
        }
        caption = (
            "Plate indentations: secant κ over the range of force, its tangents at both ends, contact, and adj. R²"
        )
        yield table_of("plates", f"{caption} of a straight line up to there", own)
        whole = [of for name in plates.specimens if (of := plates.specimen(name))]
        yield table_of("plates_specimens", "Plate indentations: κ of each specimen with its 95 % interval", _of(whole))
        names = [of.name for of in whole]
        tangents = [(name, *values) for name in names for values in zip(*plates.tangent(name), strict=True)]
        heads = ("specimen", "Specimen"), ("force_n", "F (N)"), ("tangent", "κ(F) (N/mm)"), ("half", "95 % interval ±")
        yield table_of(
            "plates_tangent", "Tangent κ(F) of the specimens by their trials",
            {Column(*head): [row[i] for row in tangents] for i, head in enumerate(heads)},
        )  # fmt: skip


def _of(whole: Sequence[SpecimenPlates]) -> Columns:
    sized: Columns = {
        Column("modulus_kpa", "Modulus (kPa)"): [of.modulus.mean if of.modulus else None for of in whole],
        Column("modulus_half_kpa", "95 % interval ± (kPa)", digits=2): [
            of.modulus.half(of.level) if of.modulus else None for of in whole
        ],
        Column("law", "Law that fits best"): [of.laws[0].law if of.laws else None for of in whole],
    }
    return {
        Column("specimen", "Specimen"): [of.name for of in whole],
        Column("kappa_n_per_mm", "κ (N/mm)", digits=4): [of.kappa.mean for of in whole],
        Column("half_n_per_mm", "95 % interval ± (N/mm)", digits=2): [of.half for of in whole],
        Column("holds_for_further", "which holds for further"): [of.level for of in whole],
        **{
            Column(level, level.capitalize()): [of.kappa.count[i] for of in whole] for i, level in enumerate(LEVELS)
        },
        Column("bend", "Change of κ over it (%)", factor=100): [of.bend for of in whole],
        Column("bend_half", "95 % interval ± (%)", factor=100, digits=2): [of.bend_half for of in whole],
        **(sized if any(of.cylinder for of in whole) else {}),
    }  # fmt: skip


def _drawings(results: StudyResults) -> Iterator[Drawing]:
    if not (plates := results.plates):
        return
    worst = plates.worst_adj_r2()
    mean = {name: of.kappa.mean for name in worst if (of := plates.specimen(name))}
    if not (names := sorted(mean, key=lambda name: -mean[name])):
        return
    look = looks([*results.specimens, *(name for name in names if name not in results.specimens)], None)
    figure = draw_plates(plates, names, look)
    origin = f" {SIMULATED}" if plates.simulated else ""
    told = "; ".join(f"{n}: {number(mean[n])} N/mm, worst adj. R² {bounded(worst[n], 4)}" for n in names)
    caption = (
        "Fig. P1. (a) Force of a flat plate against depth past contact (pale) and F = κ x of each specimen, κ over the "
        "range of force. (b) Force less the line of its own trial. (c) Tangent κ(F) with its 95 % interval, to which "
        f"trials of one mounting are one witness.{origin}"
    )
    yield Drawing("figplate_indentation", "Plate indentations", caption, f"{told}.{origin}", figure)


_TEXT = """
{{ figure("figplate_indentation") }}
{% if worst is not none %}
<p>The worst adj. R² of a straight line through a plate indentation is {{ worst | bounded(4) }} (paper: .882; that of a
parabola is .94).{% if bent %} κ is not one number for {{ bent }}.{% endif %}</p>
{% endif %}
{% if stated_spread %}
<p>{{ stated_spread }}</p>
{% endif %}
{% if doubts %}
<p>{{ doubts }}</p>
{% endif %}
{% if stated %}
<p>The study file gives κ in N/mm: {{ stated }}. There is no log of a plate (emg2vsa rig run --plate).</p>
{% else %}
{{ folded("specimens", "Stiffness of the specimens") }}
{% endif %}
{{ folded("plates_specimens", "κ by plate indentation") }}
{{ folded("plates", "Every plate indentation") }}
{{ folded("plates_tangent", "κ over force") }}
"""


def _words(results: StudyResults, q: Quantities) -> dict[str, object]:
    study, plates = results.study, results.plates
    worst = [each for each in plates.worst_adj_r2().values() if each == each] if plates else []
    bare = not plates and not any(each.stiffness_se_n_per_mm or each.plate_adjusted_r2 for each in study.specimens)
    stated = [f"{number(each.stiffness_n_per_mm)} ({each.name})" for each in study.specimens]
    return {
        "worst": min(worst, default=None), "bent": listed(list(_bent(plates)) if plates else []),
        "doubts": " ".join(_doubts(plates)) if plates else "", "stated_spread": _stated(plates) if plates else "",
        "stated": listed(stated) if bare else "",
    }  # fmt: skip


def _bent(plates: PlateTests) -> Iterator[str]:
    """Specimens with nonlinear trials, and kappa at both ends of the range."""
    for of in filter(None, map(plates.specimen, plates.specimens)):
        if of.nonlinear:
            force_n, kappa, _ = plates.tangent(of.name)
            ends = " and ".join(f"{number(kappa[i])} N/mm at {number(force_n[i])} N" for i in (0, -1))
            yield f"{of.name} ({of.nonlinear} of {count(of.trials, 'trial')}: {ends})"


def _stated(plates: PlateTests) -> str:
    """Which specimens were mounted once, and what then stands for their scatter."""
    once = [of.name for of in filter(None, map(plates.specimen, plates.specimens)) if of.kappa.count[1] == 1]
    if not once:
        return ""
    share = number(100 * plates.spread.mountings)
    return f"Mounted once: {listed(once)}; a stated SD of {share} % between mountings is in the intervals."


def _doubts(plates: PlateTests) -> Iterator[str]:
    for trial, own in zip(plates.trials, plates.ranges, strict=True):
        for reason in own.reasons:
            yield f"{trial.specimen}, trial {trial.trial}, is {own.rating}: {reason}."


PLATES = Section(
    "plates", "Stiffness of the specimens", _TEXT, lambda results: bool(results.study.specimens), _quantities, _tables,
    _drawings, _words,
)  # fmt: skip
