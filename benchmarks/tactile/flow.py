"""``casr bench flow``: every method on the same pairs of frames, time beside error."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.tactile.flow_growth import growth_table
from benchmarks.tactile.flow_pairs import FlowPair, contact_pair
from benchmarks.tactile.method import Method
from benchmarks.tactile.metrics import endpoint_error_px, pareto_front, percent_error, root_mean_square, sample_sd
from benchmarks.tactile.ours import ours
from benchmarks.tactile.peers import peers
from benchmarks.tactile.table import Cell, Table
from benchmarks.tactile.time_error_plot import Point, write_plot
from benchmarks.tactile.timing import best_times, one_thread
from casr.flow.divergence import mean_divergence
from casr.flow.pin_affine import Affine
from casr.flow.region import Region

RIM_MOTIONS_PX = (0.25, 1.0, 3.0)
TIMED_MOTION_PX = 1.0
CORE_FRACTION = 0.8
"The core leaves out the edge of the contact, which pins 20 px apart cannot resolve."
SLOW_SEEDS = 2
REFERENCE = "Horn-Schunck, whole frame"
NOTES = (
    "ms: processor time of one thread, best of interleaved repeats after a warm-up, at a rim motion of 1 px.",
    "core: error of the mean divergence over r < 64 px, mean and standard deviation over seeds, at each rim motion.",
    "EPE: mean endpoint error in the contact, r < 80 px, at a rim motion of 1 px.",
)


@dataclass(frozen=True, eq=False)
class FlowResult:
    """One method: time per pair, s; error of the core's divergence, percent, and EPE, px, both (n_motions, n_seeds)."""

    method: Method
    time_s: float
    divergence_error_percent: NDArray[np.float64]
    epe_px: NDArray[np.float64]

    @property
    def rms_percent(self) -> float:
        """Bias and spread of the divergence over all motions and seeds."""
        return root_mean_square(self.divergence_error_percent)


def run_flow(out: Path | None, n_seeds: int) -> list[Table]:
    """Errors and times, the front of unbeaten methods, growth by radius; with ``out`` their files and the plot too."""
    methods = [*ours(), *peers()]
    results = compare([method for method in methods if method.installed], n_seeds=n_seeds)
    absent = [method.name for method in methods if not method.installed]
    tables = [flow_table(results, absent, n_seeds), front_table(results), growth_table(n_seeds)]
    if out:
        points = [Point(r.method.name, 1e3 * r.time_s, r.rms_percent, r.method.ours) for r in results]
        write_plot(points, out / "flow", "rms error of the divergence at 0.25, 1 and 3 px, %")
    return tables


def compare(
    methods: Sequence[Method], *, n_seeds: int, motions_px: Sequence[float] = RIM_MOTIONS_PX, budget_s: float = 1.5
) -> list[FlowResult]:
    """Errors and times of these methods on a 127-pin sensor, 300 x 300 px, noise 2 grey levels."""
    pairs = [[contact_pair(motion, seed) for seed in range(n_seeds)] for motion in motions_px]
    timed = contact_pair(TIMED_MOTION_PX, 0)
    with one_thread():
        errors = [_errors(method, pairs) for method in methods]
        runs = {method.name: method.prepare(timed.first, timed.second, core_of(timed)) for method in methods}
        for run in runs.values():
            run()
        times = best_times(runs, budget_s=budget_s)
    return [FlowResult(m, times[m.name], *errors[i]) for i, m in enumerate(methods)]


def _errors(method: Method, pairs: list[list[FlowPair]]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    n_seeds = min(SLOW_SEEDS, len(pairs[0])) if method.slow else len(pairs[0])
    found = [[errors_of_pair(method, pair) for pair in row[:n_seeds]] for row in pairs]
    both = np.array(found)
    return both[..., 0], both[..., 1]


def errors_of_pair(method: Method, pair: FlowPair) -> tuple[float, float]:
    """Error of the core's divergence, percent, and mean endpoint error in the contact, px."""
    core = core_of(pair)
    motion = method.prepare(pair.first, pair.second, core)()
    rows, columns = np.mgrid[: pair.first.shape[0], : pair.first.shape[1]]
    grid = np.stack([columns, rows], axis=-1).astype(np.float64)
    inside = pair.contact.depth(grid) < 1
    epe = endpoint_error_px(as_flow(motion, grid)[inside], pair.flow[inside]).mean()
    return float(percent_error(divergence_of(motion, core), pair.divergence)), float(epe)


def core_of(pair: FlowPair) -> Region:
    """The inner part of the contact, where divergence is judged."""
    return Region(pair.contact.polygon_px()).scaled(CORE_FRACTION)


def divergence_of(motion: Any, core: Region) -> float:
    """Mean divergence over the core, per frame pair."""
    return float(np.trace(motion.matrix)) if isinstance(motion, Affine) else mean_divergence(motion, core.polygon_px)


def as_flow(motion: Any, grid: NDArray[np.float64]) -> NDArray[Any]:
    """The motion as (H, W, 2) px at the pixels of ``grid`` (H, W, 2)."""
    return motion.displacement_px(grid) if isinstance(motion, Affine) else motion


def flow_table(results: Sequence[FlowResult], absent: Sequence[str], n_seeds: int) -> Table:
    """One line per method."""
    reference = next((r.time_s for r in results if r.method.name == REFERENCE), results[0].time_s)
    columns = [("method", ""), ("ms", ".2f"), ("time", ".2f")]
    for motion in RIM_MOTIONS_PX:
        columns += [(f"core {motion:g} px %", "+.2f"), ("sd", ".2f")]
    rows: list[list[Cell]] = []
    for r in results:
        row: list[Cell] = [r.method.name, 1e3 * r.time_s, r.time_s / reference]
        for errors in r.divergence_error_percent:
            row += [float(errors.mean()), sample_sd(errors)]
        rows.append([*row, float(r.epe_px[RIM_MOTIONS_PX.index(TIMED_MOTION_PX)].mean())])
    rows += [[name, "not installed", *[None] * 8] for name in absent]
    slow = "; ".join(r.method.name for r in results if r.method.slow)
    seeds = f"{n_seeds} seeds; {min(SLOW_SEEDS, n_seeds)} for these: {slow}" if slow else f"{n_seeds} seeds."
    units = f"time: in units of {REFERENCE!r}. PyrLK is given the pins of the first frame."
    title = "Flow between two frames of 127 pins, 300 x 300 px, noise 2 grey levels"
    return Table("flow", title, (*columns, ("EPE px", ".3f")), rows, (*NOTES, units, seeds))


def front_table(results: Sequence[FlowResult]) -> Table:
    """Methods from fast to slow; those on the front are beaten by none in both time and error."""
    times, errors = [r.time_s for r in results], [r.rms_percent for r in results]
    front = pareto_front(times, errors)
    rows: list[list[Cell]] = [
        [results[i].method.name, 1e3 * times[i], errors[i], "unbeaten" if i in front else ""]
        for i in sorted(range(len(results)), key=times.__getitem__)
    ]
    columns = (("method", ""), ("ms", ".2f"), ("rms error %", ".2f"), ("", ""))
    return Table("flow_front", "Time against the rms error of the divergence over all motions and seeds", columns, rows)
