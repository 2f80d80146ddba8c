"""The vision algorithms: steps of Algorithm 1 and the pins that it counts; the old and the new on the same presses."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from importlib import import_module
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from casr.flow.dense_engine import dis_flow
from emg2vsa.arrays import Floats, Ints
from emg2vsa.curves.line import fit_line
from emg2vsa.discrimination.run_table import RIGID
from emg2vsa.figures.algorithm_1 import PinCounts, draw_pin_counts, draw_steps
from emg2vsa.report.designs import DESIGN, design_names, drawing, ends_of, keys, looks, of_tests, tested
from emg2vsa.report.drawing import Drawing
from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.numbers import Items, fields_of, with_interval
from emg2vsa.report.section import Quantities, Section
from emg2vsa.report.table import Column, Columns, Table, table_of
from emg2vsa.report.wording import interval
from emg2vsa.run_scores import FirstContact, RunScores
from emg2vsa.statistics.kruskal import midranks

_ANGLE_DEG = 45.0
"""Of the paper's Fig. 2."""


class _Pins(NamedTuple):
    """Force (n,) of the first frame of each press on a specimen at an angle, and pins (n,) selected in it."""

    specimen: str
    angle_deg: float
    force_n: Floats
    pins: Ints


def _counts(results: StudyResults, specimen: str, angle_deg: float) -> _Pins:
    """Of the presses of all conditions that tell both."""
    runs = [run for run in results.pressed.scores if (run.specimen, run.angle_deg) == (specimen, angle_deg)]
    force_n = np.array([n for run in runs for n in run.first_n.tolist()])
    pins = np.array([n for run in runs for n in run.pins_selected.tolist()], dtype=np.int64)
    known = np.isfinite(force_n) & (pins >= 0)
    return _Pins(specimen, angle_deg, force_n[known], pins[known])


def _each(results: StudyResults) -> list[_Pins]:
    """Every specimen at every angle that has a press."""
    table = tested(results).table
    cells = [
        _counts(results, name, angle) for angle in sorted({*table.angles_deg.tolist()}) for name in table.specimens
    ]
    return [each for each in cells if each.pins.size]


def _rank_correlation(of: _Pins) -> float:
    """Spearman's; NaN where either is constant or there are fewer than three."""
    if of.pins.size < 3 or np.ptp(of.force_n) == 0 or np.ptp(of.pins) == 0:
        return np.nan
    return float(np.corrcoef(midranks(of.force_n), midranks(of.pins))[0, 1])


def _pins_per_n(of: _Pins) -> float:
    """Slope of the counts; 0, without a rest of rounding, where they are all the same."""
    return float(fit_line(of.force_n[None], of.pins[None].astype(np.float64)).slope[0])


def _quantities(results: StudyResults) -> Items:
    every = _each(results)
    for each in every:
        name = f"runs.algorithm_1.{each.angle_deg:g}.{each.specimen}.pins"
        yield f"{name}.min", int(each.pins.min())
        yield f"{name}.median", float(np.median(each.pins))
        yield f"{name}.max", int(each.pins.max())
        yield f"{name}.rank_correlation_with_force", _rank_correlation(each)
    if every:
        pins = np.concatenate([each.pins for each in every])
        yield "runs.algorithm_1.pins.min", int(pins.min())
        yield "runs.algorithm_1.pins.max", int(pins.max())
        yield "runs.algorithm_1.pins.none", int(np.count_nonzero(pins == 0))
        yield "runs.algorithm_1.step_n.median", _step_n(results.pressed.scores)
        slopes = [_pins_per_n(each) for each in every if np.ptp(each.force_n) > 0]
        yield "runs.algorithm_1.pins_per_n.median", float(np.median(slopes)) if slopes else np.nan


def _step_n(runs: tuple[RunScores, ...]) -> float:
    """Median rise of the force between two frames, N."""
    steps = [np.diff(curve.force_n) for run in runs for curve in run.curves]
    together = np.concatenate([np.empty(0), *steps])
    return float(np.median(together)) if together.size else np.nan


def _tables(results: StudyResults, q: Quantities) -> Iterator[Table]:
    every = _each(results)
    columns: Columns = {
        Column("angle_deg", "Angle (°)", digits=2): [each.angle_deg for each in every],
        Column("specimen", "Specimen"): [each.specimen for each in every],
        Column("presses", "Presses"): [each.pins.size for each in every],
        Column("first_low_n", "First frame: least (N)"): [float(each.force_n.min()) for each in every],
        Column("first_high_n", "Largest (N)"): [float(each.force_n.max()) for each in every],
        Column("least", "n: least"): [int(each.pins.min()) for each in every],
        Column("median", "Median"): [float(np.median(each.pins)) for each in every],
        Column("most", "Largest"): [int(each.pins.max()) for each in every],
        Column("none", "Presses with n = 0"): [int(np.count_nonzero(each.pins == 0)) for each in every],
        Column("rank_correlation", "Rank correlation of n with force", digits=2): list(map(_rank_correlation, every)),
    }
    caption = f"Pins n that Algorithm 1 selects in the first frame in contact, by the {_force(results)}; {_none(every)}"
    yield table_of("algorithm_1", caption, columns)


def _force(results: StudyResults) -> str:
    """Which force of a frame the pins are counted by."""
    rule = results.study.scoring.recipe_of("paper").force_rule
    return "mean force per frame" if rule == "mean" else "force at exposure of the frame"


def _none(counts: Iterable[_Pins]) -> str:
    every = np.concatenate([np.empty(0, dtype=np.int64), *(each.pins for each in counts)])
    return f"n = 0 in {np.count_nonzero(every == 0)} of {every.size} presses, where no pin moved so far"


def _drawings(results: StudyResults) -> Iterator[Drawing]:
    look, every = looks(results), _each(results)
    if not every:
        return
    run = _pictured(results)
    if run is not None and run.first_contact is not None:
        yield _steps(results, run, run.first_contact)
    panels: dict[str, list[PinCounts]] = {}
    for name, angle, force_n, pins in every:
        panels.setdefault(f"{angle:g}°", []).append(PinCounts(name, look[name], force_n, pins))
    told = "; ".join(f"{title}: n from {_ends(specimens)}" for title, specimens in panels.items())
    caption = (
        f"Fig. A1. Pins that Algorithm 1 selects in the first frame in contact, against the {_force(results)}. One "
        f"mark per press, all conditions; pins count beyond {results.study.scoring.threshold_px:g} px. {_none(every)}."
    )
    title = "Pins that Algorithm 1 selects, by the force of its first frame"
    figure = draw_pin_counts(list(panels.items()))
    yield drawing(results, "figa1_pins_by_force", title, caption, f"{told}.", figure)


def _ends(specimens: Sequence[PinCounts]) -> str:
    together = np.concatenate([each.pins for each in specimens])
    return f"{together.min()} to {together.max()}"


def _pictured(results: StudyResults) -> RunScores | None:
    """The run of Fig. 2: rigid and at the paper's angle if there is one, of the stiffest specimen."""
    order = tested(results).table.specimens
    seen = [run for run in results.pressed.scores if run.first_contact is not None and run.specimen in order]
    return min(
        seen,
        key=lambda run: (run.condition != RIGID, abs(run.angle_deg - _ANGLE_DEG), order.index(run.specimen)),
        default=None,
    )


def _steps(results: StudyResults, run: RunScores, seen: FirstContact) -> Drawing:
    flow_px, named = _flow(seen, results.study.scoring.recipe.engine)
    count, threshold = seen.selected.size, results.study.scoring.threshold_px
    first_n, next_n = seen.force_n.tolist()
    press = f"press {seen.repetition} on {run.specimen}, {run.condition}, {run.angle_deg:g}°"
    caption = (
        f"Fig. 2. Algorithm 1 in {press}: (a) the first frame in contact ({first_n:.2f} N); (b) bright blobs; (c, d) "
        f"centroids at rest and in contact; (e) the {count} pins that moved more than {threshold:g} px, arrows four "
        f"times their motion; (f) one hexagon for each, at rest; (g) flow to the next frame, {next_n:.2f} N ({named}); "
        "(h) its divergence, yellow where skin grows."
    )
    told = f"{count} of {len(seen.rest_px)} pins are selected at {first_n:.2f} N."
    return drawing(results, "fig02_algorithm_1", "Steps of Algorithm 1", caption, told, draw_steps(seen, flow_px))


def _flow(seen: FirstContact, engine: str) -> tuple[NDArray[np.floating[Any]], str]:
    """(H, W, 2) px from the first frame in contact to the next, and what found it: DIS where the pins were scored."""
    if engine == "horn-schunck":
        # loaded when used: it compiles its kernels with numba
        dense = import_module("casr.flow.horn_schunck").horn_schunck
        return dense(seen.frames[1], seen.frames[2]), "Horn and Schunck"
    return dis_flow(seen.frames[1].astype(np.float32), seen.frames[2].astype(np.float32)), "DIS"


_TEXT = """
<p>Algorithm 1 counts pins that moved in the first frame in contact, and pins move further as the force rises. From
frame to frame the force rises by {{ q['runs.algorithm_1.step_n.median'] | number(2) }} N (median), and each 0.1 N adds
{{ (q['runs.algorithm_1.pins_per_n.median'] / 10) | number(2) }} pins. So the count tells when the frame was
taken.{% if q['runs.algorithm_1.pins.none'] %} It is 0 in {{ q['runs.algorithm_1.pins.none'] }} presses, which have no
A_c0 by Algorithm 1.{% endif %}</p>
{{ folded("algorithm_1", "Pins counted, by specimen") }}
{{ folded("figa1_pins_by_force", "Figure A1: pins counted against the force of the first frame") }}
{{ folded("fig02_algorithm_1", "Figure 2: steps of Algorithm 1") }}
"""

ALGORITHM_1 = Section("algorithm-1", "Algorithm 1 of the paper", _TEXT, of_tests, _quantities, _tables, _drawings)

_NUMBERS = ("area_ratio", "area_error", "area_error_sd", "area_cv", "casr_cv")


def _compared_quantities(results: StudyResults) -> Items:
    found = tested(results)
    compared = found.algorithms
    for a, algorithm in enumerate(compared.names):
        for i, name in enumerate(keys(found)):
            yield from fields_of(f"{name}.{algorithm}", compared, *_NUMBERS, at=(a, i))
            yield from with_interval(f"{name}.{algorithm}.gap", *ends_of(compared.gaps[a], i))


def _compared_tables(results: StudyResults, q: Quantities) -> Iterator[Table]:
    found = tested(results)
    compared, table = found.algorithms, found.table
    designs = range(len(table.conditions))
    heads = (
        f"A_c0 / that of {compared.names[0]}",
        "Error of A_c0 (%)",
        "SD of that error (%)",
        "SD of A_c0 (%)",
    )
    numbers = dict(zip(_NUMBERS, (*heads, "SD of CASR (%)"), strict=True))
    if not np.isfinite(compared.area_error).any():
        numbers = {key: head for key, head in numbers.items() if "error" not in key}
    columns: Columns = {
        Column("algorithm", "Algorithm"): np.repeat(compared.names, len(designs)),
        DESIGN: design_names(table) * len(compared.names),
        **{
            Column(key, head, 1.0 if key == "area_ratio" else 100.0): getattr(compared, key).ravel()
            for key, head in numbers.items()
        },
        Column("gap", f"{compared.pair[0]} to {compared.pair[1]}, in SDs of a press"): [
            interval(*ends_of(compared.gaps[a], i)) for a in range(len(compared.names)) for i in designs
        ],
    }
    whole = table_of("algorithms", "Vision algorithms", columns)
    rigid = tuple(row for row in whole.rows if str(row["design"]).startswith(RIGID))
    if 0 < len(rigid) < len(whole.rows):
        whole = replace(whole, caption="Vision algorithms on the same presses, rigid motor", shown_rows=rigid)
    yield whole


_COMPARED_TEXT = """
<p>"Circle" is the old algorithm. SDs are those of presses of one mounting; the distance of two specimens in such SDs
has a 95 % interval over mountings.
{% if "paper" in runs.discrimination.algorithms.names %}"Paper" follows the paper in every step.{% endif %}</p>
{{ folded("algorithms", "The algorithms on the same presses") }}
"""

VISION = Section(
    "vision", "Old and new vision algorithm", _COMPARED_TEXT, of_tests, _compared_quantities, _compared_tables
)
