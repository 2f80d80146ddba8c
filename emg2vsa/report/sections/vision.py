"""The vision algorithms: steps of Algorithm 1 and the pins that it counts; the old and the new on the same presses."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import product

import numpy as np

from casr.by_name import module_named
from casr.flow.dense_engine import dis_flow
from emg2vsa.arrays import Floats, Ints
from emg2vsa.curves.line import fit_line
from emg2vsa.discrimination.run_table import RIGID
from emg2vsa.figures.algorithm_1 import draw_steps
from emg2vsa.report import designs
from emg2vsa.report.designs import cells, design_name, keys, of_tests, tested
from emg2vsa.report.drawing import Drawing
from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.numbers import Items, median
from emg2vsa.report.section import Quantities, Section
from emg2vsa.report.table import Column, Columns, Table, columns, table_of
from emg2vsa.statistics.kruskal import midranks

_ANGLE_DEG = 45.0
"""Angle of the paper's Fig. 2."""
_NUMBERS = ("area_ratio", "area_error", "area_error_sd", "area_cv", "casr_cv")


def _pins(results: StudyResults) -> Iterator[tuple[float, str, Floats, Ints]]:
    """Angle, specimen, and (n,) forces and pins that Algorithm 1 selects in first frames of presses that tell both."""
    table = tested(results).table
    for angle, name in product(sorted({*table.angles_deg.tolist()}), table.specimens):
        runs = [run for run in results.pressed.scores if (run.specimen, run.angle_deg) == (name, angle)]
        force_n = np.concatenate([np.empty(0), *(run.first_n for run in runs)])
        pins = np.concatenate([np.empty(0, dtype=np.int64), *(run.pins_selected for run in runs)])
        known = np.isfinite(force_n) & (pins >= 0)
        if known.any():
            yield angle, name, force_n[known], pins[known]


def _quantities(results: StudyResults) -> Items:
    counts, per_n = [], [np.nan]
    for angle, specimen, force_n, pins in _pins(results):
        name, several = f"runs.algorithm_1.{angle:g}.{specimen}.pins", np.ptp(force_n) > 0
        yield f"{name}.min", int(pins.min())
        yield f"{name}.median", float(np.median(pins))
        yield f"{name}.max", int(pins.max())
        ranked = pins.size > 2 and several and np.ptp(pins) > 0
        rank_correlation = np.corrcoef(midranks(force_n), midranks(pins))[0, 1] if ranked else np.nan
        yield f"{name}.rank_correlation_with_force", float(rank_correlation)
        counts.append(pins)
        if several:
            # 0, without a rest of rounding, where all counts are the same
            per_n.append(float(fit_line(force_n[None], pins[None].astype(np.float64)).slope[0]))
    if counts:
        pins, steps = np.concatenate(counts), [np.diff(c.force_n) for run in results.pressed.scores for c in run.curves]
        yield "runs.algorithm_1.pins.min", int(pins.min())
        yield "runs.algorithm_1.pins.max", int(pins.max())
        yield "runs.algorithm_1.pins.none", int(np.count_nonzero(pins == 0))
        yield "runs.algorithm_1.step_n.median", median(np.concatenate([np.empty(0), *steps]))
        yield "runs.algorithm_1.pins_per_n.median", median(np.array(per_n))
    found = tested(results)
    for a, algorithm in enumerate(found.algorithms.names):
        of_algorithm = {key: getattr(found.algorithms, key)[a] for key in (*_NUMBERS, "gaps")}
        yield from designs.of_designs(found, {f"{algorithm}.{k.removesuffix('s')}": v for k, v in of_algorithm.items()})


def _tables(results: StudyResults, q: Quantities) -> Iterator[Table]:
    yield _counted(results, q)
    yield _compared(results, q)


def _counted(results: StudyResults, q: Quantities) -> Table:
    """Pins that Algorithm 1 selects, by angle and specimen."""
    every, rule = [*_pins(results)], results.study.scoring.recipe_of("paper").force_rule
    names = [f"runs.algorithm_1.{angle:g}.{specimen}.pins" for angle, specimen, *_ in every]
    counted: Columns = {
        Column("angle_deg", "Angle (°)", digits=2): [angle for angle, *_ in every],
        Column("specimen", "Specimen"): [specimen for _, specimen, *_ in every],
        Column("presses", "Presses"): [pins.size for *_, pins in every],
        Column("first_low_n", "First frame: least (N)"): [float(force_n.min()) for *_, force_n, _ in every],
        Column("first_high_n", "Largest (N)"): [float(force_n.max()) for *_, force_n, _ in every],
        Column("least", "n: least"): cells(q, names, "min"),
        Column("median", "Median"): cells(q, names, "median"),
        Column("most", "Largest"): cells(q, names, "max"),
        Column("none", "Presses with n = 0"): [int(np.count_nonzero(pins == 0)) for *_, pins in every],
        Column("rank_correlation", "Rank correlation of n with force", digits=2): cells(
            q, names, "rank_correlation_with_force"
        ),
    }
    caption = (
        "Pins n that Algorithm 1 selects in the first frame in contact, by the "
        f"{'mean force per frame' if rule == 'mean' else 'force at exposure of the frame'}; n = 0 in "
        f"{q.get('runs.algorithm_1.pins.none', 0)} of {sum(p.size for *_, p in every)} presses, where no pin moved"
    )
    return table_of("algorithm_1", caption, counted)


def _compared(results: StudyResults, q: Quantities) -> Table:
    """Vision algorithms on the same presses, by design."""
    found = tested(results)
    compared, table = found.algorithms, found.table
    shown = _NUMBERS if np.isfinite(compared.area_error).any() else (_NUMBERS[0], *_NUMBERS[3:])
    names, count = [design_name(table, i) for i in range(len(table.conditions))], len(compared.names)
    rows: Columns = {
        Column("algorithm", "Algorithm"): np.repeat(compared.names, len(names)),
        designs.DESIGN: names * count,
        **columns(compared, *shown, at=(np.repeat(range(count), len(names)), np.tile(range(len(names)), count))),
        Column("gap", f"{compared.pair[0]} to {compared.pair[1]}, in SDs of a press"): [
            each for name in compared.names for each in cells(q, keys(found), f"{name}.gap")
        ],
    }
    caption = (
        "Vision algorithms on the same presses; SDs are those of presses of one mounting, the interval of the distance "
        "is one over mountings"
    )
    whole = table_of("algorithms", caption, rows)
    rigid = tuple(row for row in whole.rows if str(row["design"]).startswith(RIGID))
    some = 0 < len(rigid) < len(whole.rows)
    return replace(whole, caption=f"{caption}. Shown: rigid motor", shown_rows=rigid) if some else whole


def _drawings(results: StudyResults) -> Iterator[Drawing]:
    """Figure 2, of a run that is rigid and at the paper's angle if there is one, of the stiffest specimen."""
    order, scoring = tested(results).table.specimens, results.study.scoring
    run = min(
        (run for run in results.pressed.scores if run.first_contact is not None and run.specimen in order),
        key=lambda run: (run.condition != RIGID, abs(run.angle_deg - _ANGLE_DEG), order.index(run.specimen)),
        default=None,
    )
    if run is None or (seen := run.first_contact) is None:
        return
    first, later = seen.frames[1:]
    if scoring.recipe.engine == "horn-schunck":
        # loaded when used: it compiles its kernels with numba
        flow_px, named = module_named("casr.flow.horn_schunck").horn_schunck(first, later), "Horn–Schunck"
    else:
        flow_px, named = dis_flow(first.astype(np.float32), later.astype(np.float32)), "DIS"
    first_n, next_n = seen.force_n.tolist()
    caption = (
        f"Fig. 2. Algorithm 1, press {seen.repetition} on {run.specimen}, {run.condition}, {run.angle_deg:g}°: pins "
        f"that moved more than {scoring.threshold_px:g} px in the first frame ({first_n:.2f} N; arrows × 4) get "
        f"hexagons; {named} flow to {next_n:.2f} N."
    )
    told = f"{seen.selected.size} of {len(seen.rest_px)} pins are selected at {first_n:.2f} N."
    figure = draw_steps(seen, flow_px)
    yield designs.drawing(results, "fig02_algorithm_1", "Steps of Algorithm 1", caption, told, figure)


_TEXT = """
{{ figure("fig02_algorithm_1") }}
{% if "runs.algorithm_1.step_n.median" in q %}
<p>How many pins Algorithm 1 counts depends on the moment of the first frame in contact: from one frame to the next the
force rises by {{ q["runs.algorithm_1.step_n.median"] | number(2) }} N, and 0.1 N more makes the count
{{ (q["runs.algorithm_1.pins_per_n.median"] / 10) | number(2) }} pins larger.
{% if q["runs.algorithm_1.pins.none"] %}In {{ q["runs.algorithm_1.pins.none"] }} presses no pin moved.{% endif %}</p>
{% endif %}
{{ folded("algorithm_1", "Pins counted, by specimen") }}
{{ folded("algorithms", "Old (circle) and new vision algorithms on the same presses") }}
"""

VISION = Section("vision", "Vision algorithms", _TEXT, of_tests, _quantities, _tables, _drawings)
