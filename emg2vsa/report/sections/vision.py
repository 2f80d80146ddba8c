"""The vision algorithms: steps of Algorithm 1 and the pins that it counts; the old and the new on the same presses."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import NDArray

from casr.flow.dense_engine import dis_flow
from emg2vsa.arrays import Floats, Ints
from emg2vsa.curves.line import fit_line
from emg2vsa.discrimination.run_table import RIGID
from emg2vsa.figures.algorithm_1 import draw_steps
from emg2vsa.report import designs
from emg2vsa.report.designs import design_name, of_tests, tested
from emg2vsa.report.drawing import Drawing
from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.numbers import Items
from emg2vsa.report.section import Quantities, Section
from emg2vsa.report.table import Column, Columns, Table, columns, records, table_of
from emg2vsa.run_scores import FirstContact, RunScores
from emg2vsa.shown import shown, words_of
from emg2vsa.statistics.kruskal import midranks

_ANGLE_DEG = 45.0
"""Of the paper's Fig. 2."""
_NUMBERS = ("area_ratio", "area_error", "area_error_sd", "area_cv", "casr_cv")


@dataclass(frozen=True)
class _Pins:
    """Pins that Algorithm 1 selects in the first frame of the presses on a specimen at an angle, of all conditions."""

    angle_deg: float = field(metadata=shown("Angle (°)", digits=2))
    specimen: str = field(metadata=shown("Specimen"))
    presses: int = field(metadata=shown("Presses"))
    first_low_n: float = field(metadata=shown("First frame: least (N)"))
    first_high_n: float = field(metadata=shown("Largest (N)"))
    least: int = field(metadata=shown("n: least"))
    median: float = field(metadata=shown("Median"))
    most: int = field(metadata=shown("Largest"))
    none: int = field(metadata=shown("Presses with n = 0"))
    rank_correlation: float = field(metadata=shown("Rank correlation of n with force", digits=2))
    pins_per_n: float
    "NaN where all first frames have one force."


def _pins(results: StudyResults) -> list[_Pins]:
    """Of every specimen at every angle with a press that tells the force and the pins of its first frame."""
    table, found = tested(results).table, []
    for angle in sorted({*table.angles_deg.tolist()}):
        for name in table.specimens:
            runs = [run for run in results.pressed.scores if (run.specimen, run.angle_deg) == (name, angle)]
            force_n = np.concatenate([np.empty(0), *(run.first_n for run in runs)])
            pins = np.concatenate([np.empty(0, dtype=np.int64), *(run.pins_selected for run in runs)])
            known = np.isfinite(force_n) & (pins >= 0)
            if known.any():
                found.append(_counted(angle, name, force_n[known], pins[known]))
    return found


def _counted(angle_deg: float, specimen: str, force_n: Floats, pins: Ints) -> _Pins:
    several = np.ptp(force_n) > 0
    ranks = midranks(force_n), midranks(pins)
    return _Pins(
        angle_deg, specimen, pins.size, float(force_n.min()), float(force_n.max()), int(pins.min()),
        float(np.median(pins)), int(pins.max()), int(np.count_nonzero(pins == 0)),
        float(np.corrcoef(*ranks)[0, 1]) if pins.size > 2 and several and np.ptp(pins) > 0 else np.nan,
        # 0, without a rest of rounding, where all counts are the same
        float(fit_line(force_n[None], pins[None].astype(np.float64)).slope[0]) if several else np.nan,
    )  # fmt: skip


def _quantities(results: StudyResults) -> Items:
    every = _pins(results)
    for each in every:
        name = f"runs.algorithm_1.{each.angle_deg:g}.{each.specimen}.pins"
        yield from zip(
            (f"{name}.min", f"{name}.median", f"{name}.max"), (each.least, each.median, each.most), strict=True
        )
        yield f"{name}.rank_correlation_with_force", each.rank_correlation
    if every:
        yield "runs.algorithm_1.pins.min", min(each.least for each in every)
        yield "runs.algorithm_1.pins.max", max(each.most for each in every)
        yield "runs.algorithm_1.pins.none", sum(each.none for each in every)
        steps = [np.diff(curve.force_n) for run in results.pressed.scores for curve in run.curves]
        yield "runs.algorithm_1.step_n.median", _median(np.concatenate([np.empty(0), *steps]))
        yield "runs.algorithm_1.pins_per_n.median", _median(designs.finite(np.array([e.pins_per_n for e in every])))
    found = tested(results)
    for a, algorithm in enumerate(found.algorithms.names):
        of_algorithm = {key: getattr(found.algorithms, key)[a] for key in _NUMBERS} | {"gap": found.algorithms.gaps[a]}
        yield from designs.of_designs(found, {f"{algorithm}.{key}": each for key, each in of_algorithm.items()})


def _median(values: Floats) -> float:
    return float(np.median(values)) if values.size else np.nan


def _tables(results: StudyResults, q: Quantities) -> Iterator[Table]:
    every, rule = _pins(results), results.study.scoring.recipe_of("paper").force_rule
    heads = tuple(Column(key, *words) for key, words in words_of(_Pins).items())
    caption = (
        "Pins n that Algorithm 1 selects in the first frame in contact, by the "
        f"{'mean force per frame' if rule == 'mean' else 'force at exposure of the frame'}; n = 0 in "
        f"{sum(each.none for each in every)} of {sum(each.presses for each in every)} presses, where no pin moved"
    )
    yield Table("algorithm_1", caption, heads, records(every, heads))
    yield _compared(results)


def _compared(results: StudyResults) -> Table:
    found = tested(results)
    compared, table = found.algorithms, found.table
    shown = _NUMBERS if np.isfinite(compared.area_error).any() else (_NUMBERS[0], *_NUMBERS[3:])
    names, count = [design_name(table, i) for i in range(len(table.conditions))], len(compared.names)
    rows: Columns = {
        Column("algorithm", "Algorithm"): np.repeat(compared.names, len(names)),
        designs.DESIGN: names * count,
        **columns(compared, *shown, at=(np.repeat(range(count), len(names)), np.tile(range(len(names)), count))),
        Column("gap", f"{compared.pair[0]} to {compared.pair[1]}, in SDs of a press"): [
            each for gaps in compared.gaps for each in designs.said(gaps)
        ],
    }
    caption = (
        "Vision algorithms on the same presses; SDs are those of presses of one mounting, the interval of the distance "
        "is one over mountings"
    )
    whole = table_of("algorithms", caption, rows)
    rigid = tuple(row for row in whole.rows if str(row["design"]).startswith(RIGID))
    if 0 < len(rigid) < len(whole.rows):
        whole = replace(whole, caption=f"{caption}. Shown: rigid motor", shown_rows=rigid)
    return whole


def _drawings(results: StudyResults) -> Iterator[Drawing]:
    run = _pictured(results)
    if run is not None and run.first_contact is not None:
        yield _steps(results, run, run.first_contact)


def _pictured(results: StudyResults) -> RunScores | None:
    """The run of Fig. 2: rigid and at the paper's angle if there is one, of the stiffest specimen."""
    order = tested(results).table.specimens
    return min(
        (run for run in results.pressed.scores if run.first_contact is not None and run.specimen in order),
        key=lambda run: (run.condition != RIGID, abs(run.angle_deg - _ANGLE_DEG), order.index(run.specimen)),
        default=None,
    )


def _steps(results: StudyResults, run: RunScores, seen: FirstContact) -> Drawing:
    flow_px, named = _flow(seen, results.study.scoring.recipe.engine)
    count, threshold = seen.selected.size, results.study.scoring.threshold_px
    first_n, next_n = seen.force_n.tolist()
    press = f"press {seen.repetition} on {run.specimen}, {run.condition}, {run.angle_deg:g}°"
    caption = (
        f"Fig. 2. Algorithm 1, {press}: pins that moved more than {threshold:g} px in the first frame ({first_n:.2f} "
        f"N; arrows × 4) get hexagons; {named} flow to {next_n:.2f} N."
    )
    told = f"{count} of {len(seen.rest_px)} pins are selected at {first_n:.2f} N."
    figure = draw_steps(seen, flow_px)
    return designs.drawing(results, "fig02_algorithm_1", "Steps of Algorithm 1", caption, told, figure)


def _flow(seen: FirstContact, engine: str) -> tuple[NDArray[np.floating[Any]], str]:
    """(H, W, 2) px from the first frame in contact to the next, and what found it: DIS where the pins were scored."""
    if engine == "horn-schunck":
        # loaded when used: it compiles its kernels with numba
        dense = import_module("casr.flow.horn_schunck").horn_schunck
        return dense(seen.frames[1], seen.frames[2]), "Horn–Schunck"
    return dis_flow(seen.frames[1].astype(np.float32), seen.frames[2].astype(np.float32)), "DIS"


_TEXT = """
{{ figure("fig02_algorithm_1") }}
{% if "runs.algorithm_1.step_n.median" in q %}
<p>The count of pins tells when the first frame was taken: the force rises by
{{ q["runs.algorithm_1.step_n.median"] | number(2) }} N a frame, and 0.1 N adds
{{ (q["runs.algorithm_1.pins_per_n.median"] / 10) | number(2) }} pins.
{% if q["runs.algorithm_1.pins.none"] %}In {{ q["runs.algorithm_1.pins.none"] }} presses no pin moved.{% endif %}</p>
{% endif %}
{{ folded("algorithm_1", "Pins counted, by specimen") }}
{{ folded("algorithms", "Old (circle) and new vision algorithms on the same presses") }}
"""

VISION = Section("vision", "Vision algorithms", _TEXT, of_tests, _quantities, _tables, _drawings)
