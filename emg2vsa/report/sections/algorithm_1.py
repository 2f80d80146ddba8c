"""Algorithm 1 of the paper: its steps in one press, and how many pins it counts by the force of its first frame."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import NDArray

from casr.flow.dense_engine import dis_flow
from emg2vsa.arrays import Floats, Ints
from emg2vsa.curves.line import fit_line
from emg2vsa.discrimination.run_table import RIGID
from emg2vsa.figures.algorithm_1 import PinCounts, draw_pin_counts, draw_steps
from emg2vsa.report.designs import drawing, looks, of_tests, tested
from emg2vsa.report.drawing import Drawing
from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.numbers import Items
from emg2vsa.report.section import Quantities, Section
from emg2vsa.report.table import Column, Table, rows_of
from emg2vsa.run_scores import FirstContact, RunScores
from emg2vsa.statistics.kruskal import midranks

_ANGLE_DEG = 45.0
"""Of the paper's Fig. 2."""


def _counts(results: StudyResults, specimen: str, angle_deg: float) -> tuple[Floats, Ints]:
    """Force of the first frame (n,) and pins selected in it (n,), of the presses of all conditions that tell both."""
    runs = [run for run in results.pressed.scores if (run.specimen, run.angle_deg) == (specimen, angle_deg)]
    force_n = np.array([n for run in runs for n in run.first_n.tolist()])
    pins = np.array([n for run in runs for n in run.pins_selected.tolist()], dtype=np.int64)
    known = np.isfinite(force_n) & (pins >= 0)
    return force_n[known], pins[known]


def _each(results: StudyResults) -> Iterator[tuple[str, float, Floats, Ints]]:
    """Specimen, angle, forces and pins, where there is a press."""
    table = tested(results).table
    for angle in sorted(set(table.angles_deg.tolist())):
        for specimen in table.specimens:
            force_n, pins = _counts(results, specimen, angle)
            if pins.size:
                yield specimen, angle, force_n, pins


def _rank_correlation(first: Floats, second: Ints) -> float:
    """Spearman's; NaN where either is constant or there are fewer than three."""
    if first.size < 3 or np.ptp(first) == 0 or np.ptp(second) == 0:
        return np.nan
    return float(np.corrcoef(midranks(first), midranks(second))[0, 1])


def _pins_per_n(force_n: Floats, pins: Ints) -> float:
    """Slope of the counts; 0, without a rest of rounding, where they are all the same."""
    return float(fit_line(force_n[None], pins[None].astype(np.float64)).slope[0])


def _quantities(results: StudyResults) -> Items:
    every = list(_each(results))
    for specimen, angle, force_n, pins in every:
        name = f"runs.algorithm_1.{angle:g}.{specimen}"
        yield f"{name}.pins.min", int(pins.min())
        yield f"{name}.pins.median", float(np.median(pins))
        yield f"{name}.pins.max", int(pins.max())
        yield f"{name}.pins.rank_correlation_with_force", _rank_correlation(force_n, pins)
    if every:
        yield "runs.algorithm_1.pins.min", int(min(pins.min() for *_, pins in every))
        yield "runs.algorithm_1.pins.max", int(max(pins.max() for *_, pins in every))
        yield "runs.algorithm_1.pins.none", int(sum(np.count_nonzero(pins == 0) for *_, pins in every))
        yield "runs.algorithm_1.step_n.median", _step_n(results.pressed.scores)
        slopes = [_pins_per_n(force_n, pins) for _, _, force_n, pins in every if np.ptp(force_n) > 0]
        yield "runs.algorithm_1.pins_per_n.median", float(np.median(slopes)) if slopes else np.nan


def _step_n(runs: tuple[RunScores, ...]) -> float:
    """Median rise of the force between two frames, N."""
    steps = [np.diff(curve.force_n) for run in runs for curve in run.curves]
    together = np.concatenate([np.empty(0), *steps])
    return float(np.median(together)) if together.size else np.nan


def _tables(results: StudyResults, q: Quantities) -> Iterator[Table]:
    columns = (
        Column("angle_deg", "Angle (°)", digits=2), Column("specimen", "Specimen"), Column("presses", "Presses"),
        Column("first_low_n", "First frame: least (N)"), Column("first_high_n", "Largest (N)"),
        Column("least", "n: least"), Column("median", "Median"), Column("most", "Largest"),
        Column("none", "Presses with n = 0"),
        Column("rank_correlation", "Rank correlation of n with force", digits=2),
    )  # fmt: skip
    every = list(_each(results))
    rows = rows_of(
        {
            "angle_deg": [angle for _, angle, _, _ in every],
            "specimen": [specimen for specimen, _, _, _ in every],
            "presses": [pins.size for *_, pins in every],
            "first_low_n": [float(force_n.min()) for _, _, force_n, _ in every],
            "first_high_n": [float(force_n.max()) for _, _, force_n, _ in every],
            "least": [int(pins.min()) for *_, pins in every],
            "median": [float(np.median(pins)) for *_, pins in every],
            "most": [int(pins.max()) for *_, pins in every],
            "none": [int(np.count_nonzero(pins == 0)) for *_, pins in every],
            "rank_correlation": [_rank_correlation(force_n, pins) for _, _, force_n, pins in every],
        }
    )
    caption = (
        f"Pins n that Algorithm 1 selects in the first frame in contact, by the {_force(results)}; "
        f"{_none(pins for *_, pins in every)}"
    )
    yield Table("algorithm_1", caption, columns, rows)


def _force(results: StudyResults) -> str:
    """Which force of a frame the pins are counted by."""
    rule = results.study.scoring.recipe_of("paper").force_rule
    return "mean force per frame" if rule == "mean" else "force at exposure of the frame"


def _none(counts: Iterable[Ints]) -> str:
    every = np.concatenate([np.empty(0, dtype=np.int64), *counts])
    return f"n = 0 in {np.count_nonzero(every == 0)} of {every.size} presses, where no pin moved so far"


def _drawings(results: StudyResults) -> Iterator[Drawing]:
    look = looks(results)
    by_angle: dict[float, list[PinCounts]] = {}
    for specimen, angle, force_n, pins in _each(results):
        by_angle.setdefault(angle, []).append(PinCounts(specimen, look[specimen], force_n, pins))
    if not by_angle:
        return
    run = _pictured(results)
    if run is not None and run.first_contact is not None:
        yield _steps(results, run, run.first_contact)
    panels = [(f"{angle:g}°", specimens) for angle, specimens in by_angle.items()]
    told = "; ".join(f"{title}: n from {_ends(specimens)}" for title, specimens in panels)
    yield drawing(
        results, "figa1_pins_by_force", "Pins that Algorithm 1 selects, by the force of its first frame",
        f"Fig. A1. Pins that Algorithm 1 selects in the first frame in contact, against the {_force(results)}. One "
        f"mark per press, all conditions; pins count beyond {results.study.scoring.threshold_px:g} px. "
        f"{_none(each.pins for specimens in by_angle.values() for each in specimens)}.",
        told + ".", draw_pin_counts(panels),
    )  # fmt: skip


def _ends(specimens: list[PinCounts]) -> str:
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
