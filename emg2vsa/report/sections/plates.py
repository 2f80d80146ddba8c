"""Stiffness of the specimens: what the study file says, and indentations by a flat plate where there are logs."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from emg2vsa.curves.plate import PlateTests
from emg2vsa.figures.palette import looks
from emg2vsa.figures.plates import draw_plates
from emg2vsa.report.drawing import Drawing
from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.numbers import Items, moments
from emg2vsa.report.section import Quantities, Section
from emg2vsa.report.table import Column, Columns, Table, columns, table_of
from emg2vsa.report.wording import SIMULATED, bounded, count, listed, number


def _quantities(results: StudyResults) -> Items:
    if plates := results.plates:
        yield "plates.simulated", plates.simulated
        for name, worst in plates.worst_adj_r2().items():
            yield from moments(f"plates.{name}.kappa_n_per_mm", plates.fit.kappa[plates.of(name)])
            yield f"plates.{name}.trials", len(plates.of(name))
            yield f"plates.{name}.adj_r2.min", worst


def _tables(results: StudyResults, q: Quantities) -> Iterator[Table]:
    study, plates = results.study, results.plates
    stated: Columns = {
        Column("specimen", "Specimen"): results.specimens,
        Column("stiffness_n_per_mm", "κ (N/mm)"): [each.stiffness_n_per_mm for each in study.specimens],
        Column("stiffness_se_n_per_mm", "Standard error", digits=2): [
            each.stiffness_se_n_per_mm or None for each in study.specimens
        ],
        Column("plate_adjusted_r2", "Worst adj. R² of a line", digits=4): [
            each.plate_adjusted_r2 for each in study.specimens
        ],
    }
    yield table_of("specimens", "Stiffness of the specimens by plate indentation, as the study file has it", stated)
    if plates:
        own: Columns = {
            Column("specimen", "Specimen"): plates.specimens,
            Column("trial", "Trial"): plates.trials,
            **columns(plates.fit, "kappa", "kappa_se", "contact", "adj_r2", "n", "first_half", "second_half"),
        }
        caption = "Plate indentations: F = κ (x − x0) up to the deepest point, by least squares; points as independent"
        yield table_of("plates", caption, own)


def _drawings(results: StudyResults) -> Iterator[Drawing]:
    if not (plates := results.plates):
        return
    worst, kappa = plates.worst_adj_r2(), plates.fit.kappa
    mean = {name: float(np.mean(kappa[own])) for name in worst if (own := plates.of(name))}
    if not (names := sorted(mean, key=lambda name: -mean[name])):
        return
    look = looks([*results.specimens, *(name for name in names if name not in results.specimens)], None)
    figure = draw_plates(plates, names, look)
    origin = f" {SIMULATED}" if plates.simulated else ""
    told = "; ".join(f"{n}: {number(mean[n])} N/mm, worst adj. R² {bounded(worst[n], 4)}" for n in names)
    caption = (
        "Fig. P1. Force of a flat plate against depth past contact (pale) with F = κ x of each specimen; right: force "
        f"less that line.{origin}"
    )
    yield Drawing("figplate_indentation", "Plate indentations", caption, f"{told}.{origin}", figure)


_TEXT = """
{{ figure("figplate_indentation") }}
{% if worst is not none %}
<p>The worst adj. R² of a straight line through a plate indentation is {{ worst | bounded(4) }} (paper: .882; that of a
parabola is .94).{% if bent %} Halves of a trial differ by more than 10 % for {{ bent }}.{% endif %}</p>
{% endif %}
{% if lost %}
<p>In {{ lost | count("trial") }} the force does not rise with indentation. Check its sign.</p>
{% endif %}
{% if stated %}
<p>The study file gives κ in N/mm: {{ stated }}. There is no log of a plate (emg2vsa rig run --plate).</p>
{% else %}
{{ folded("specimens", "Stiffness of the specimens") }}
{% endif %}
{{ folded("plates", "Every plate indentation") }}
"""


def _words(results: StudyResults, q: Quantities) -> dict[str, object]:
    study, plates = results.study, results.plates
    worst = [each for each in plates.worst_adj_r2().values() if each == each] if plates else []
    lost = int(np.count_nonzero(~(plates.fit.kappa > 0))) if plates else 0
    bare = not plates and not any(each.stiffness_se_n_per_mm or each.plate_adjusted_r2 for each in study.specimens)
    stated = [f"{number(each.stiffness_n_per_mm)} ({each.name})" for each in study.specimens]
    return {
        "worst": min(worst, default=None), "lost": lost, "bent": listed(list(_bent(plates)) if plates else []),
        "stated": listed(stated) if bare else "",
    }  # fmt: skip


def _bent(plates: PlateTests) -> Iterator[str]:
    """Specimens with trials that bend, and the mean stiffness of both halves."""
    fit = plates.fit
    for name in dict.fromkeys(plates.specimens):
        own = plates.of(name)
        if bent := [i for i in own if fit.bends[i]]:
            halves = f"{number(fit.first_half[bent].mean())}, then {number(fit.second_half[bent].mean())} N/mm"
            yield f"{name} ({len(bent)} of {count(len(own), 'trial')}: {halves})"


PLATES = Section(
    "plates", "Stiffness of the specimens", _TEXT, lambda results: bool(results.study.specimens), _quantities, _tables,
    _drawings, _words,
)  # fmt: skip
