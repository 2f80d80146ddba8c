"""``casr bench numerics``: where the arithmetic holds and what the scene does to the divergence."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from itertools import cycle, islice

import numpy as np
from numpy.typing import NDArray

from benchmarks.tactile.flow_pairs import FlowPair, contact_pair
from benchmarks.tactile.metrics import percent_error, sample_sd
from benchmarks.tactile.table import Cell, Table
from benchmarks.tactile.timing import one_thread, peak_memory_mb
from casr.errors import CasrError
from casr.flow.estimate import ENGINES, FlowSettings, FlowTracker
from casr.flow.horn_schunck import HornSchunckSettings, horn_schunck
from casr.flow.region import Region
from casr.images import Grey
from emg2vsa.worlds.tactile import Appearance

RIM_MOTION_PX = 1.0
ALPHAS = (1e-3, 1.0, 3.0, 10.0, 30.0, 60.0, 100.0, 300.0, 1e4)
PRESMOOTHING_PX = (0.0, 1.0, 1.5, 2.0)
SCENES = {
    "noise 0": Appearance(noise_grey=0),
    "noise 2": Appearance(),
    "noise 4": Appearance(noise_grey=4),
    "noise 8": Appearance(noise_grey=8),
    "texture 12, moving with the skin": Appearance(texture_grey=12),
    "dirt 12, static": Appearance(dirt_grey=12),
    "5 reflections": Appearance(n_glare=5),
    "10 pins missing": Appearance(n_missing=10),
}
STREAMED_FRAMES = (200, 2000)


def run_numerics(n_seeds: int) -> list[Table]:
    """Every table of this comparison."""
    with one_thread():
        return [
            identical_table(),
            precision_table(),
            settings_table(n_seeds),
            scene_table(n_seeds),
            streaming_table(),
        ]


def identical_table() -> Table:
    """Divergence of a frame against itself: exactly 0."""
    pair = contact_pair(RIM_MOTION_PX)
    rows: list[list[Cell]] = [
        [engine, measured(FlowSettings(engine=engine), pair.first, pair.first, pair)] for engine in ENGINES
    ]
    return Table("identical", "Identical frames", (("engine", ""), ("divergence", "g")), rows)


def precision_table() -> Table:
    """The solver in single against double precision, over the range of alpha."""
    pair = contact_pair(RIM_MOTION_PX)
    rows: list[list[Cell]] = []
    for alpha in ALPHAS:
        single, double = (
            horn_schunck(pair.first, pair.second, settings=HornSchunckSettings(alpha=alpha, precision=precision))
            for precision in ("single", "double")
        )
        difference = np.abs(single.astype(np.float64) - double)
        rows.append([f"{alpha:g}", float(difference.max()), float(np.abs(double).max())])
    columns = (("alpha", ""), ("largest difference px", ".1e"), ("largest flow px", ".3f"))
    return Table("precision", "Horn-Schunck in single and in double precision, rim motion 1 px", columns, rows)


def settings_table(n_seeds: int) -> Table:
    """Error of the divergence for alpha and presmoothing."""
    pairs = [contact_pair(RIM_MOTION_PX, seed) for seed in range(n_seeds)]
    rows: list[list[Cell]] = []
    for alpha in ALPHAS:
        row: list[Cell] = [f"{alpha:g}"]
        for presmoothing in PRESMOOTHING_PX:
            solver = HornSchunckSettings(alpha=alpha, presmoothing_px=presmoothing)
            row += mean_sd(errors(FlowSettings(engine="horn-schunck", horn_schunck=solver), pairs))
        rows.append(row)
    smoothing = [column for px in PRESMOOTHING_PX for column in ((f"{px:g} px", "+.2f"), ("sd", ".2f"))]
    title = "Horn-Schunck: error of the divergence in % by alpha (down) and presmoothing (across), rim motion 1 px"
    return Table("horn_schunck_settings", title, (("alpha", ""), *smoothing), rows)


def scene_table(n_seeds: int) -> Table:
    """Error of the divergence for noise, texture, dirt, reflections and missing pins, by engine."""
    rows: list[list[Cell]] = []
    for name, appearance in SCENES.items():
        pairs = [contact_pair(RIM_MOTION_PX, seed, appearance=appearance) for seed in range(n_seeds)]
        rows.append(
            [name, *[cell for engine in ENGINES for cell in mean_sd(errors(FlowSettings(engine=engine), pairs))]]
        )
    columns = [column for engine in ENGINES for column in ((engine, "+.2f"), ("sd", ".2f"))]
    note = "Mean and standard deviation over seeds; '-': the engine found too little to go by, and said so."
    title = "Error of the divergence in % by scene, rim motion 1 px; grey levels"
    return Table("scenes", title, (("scene", ""), *columns), rows, (note,))


def streaming_table() -> Table:
    """Time per frame and memory as the stream grows."""
    pair = contact_pair(RIM_MOTION_PX)
    region = Region(pair.contact.polygon_px())
    rows: list[list[Cell]] = []
    for engine in ENGINES:
        tracker = FlowTracker(FlowSettings(engine=engine))
        tracker.start(pair.first, region)
        frames = cycle((pair.second, pair.first))
        _stream(tracker, islice(frames, 10))
        before_mb, times_s = peak_memory_mb(), []
        memory: list[Cell] = []
        for n_frames in STREAMED_FRAMES:
            times_s.append(_stream(tracker, islice(frames, n_frames)) / n_frames)
            memory.append(peak_memory_mb() - before_mb)
        rows.append([engine, 1e3 * min(times_s), *memory])
    grown = tuple((f"MB after {n}", ".1f") for n in STREAMED_FRAMES)
    title = "Streaming: processor time per frame, and how far peak memory grew while frames came in"
    return Table("streaming", title, (("engine", ""), ("ms", ".2f"), *grown), rows)


def _stream(tracker: FlowTracker, frames: Iterator[NDArray[np.uint8]]) -> float:
    """Processor time of these steps, s."""
    start = time.process_time()
    for frame in frames:
        tracker.step(frame)
    return time.process_time() - start


def errors(settings: FlowSettings, pairs: Sequence[FlowPair]) -> list[float]:
    """Error of the divergence of each pair, percent; pairs an engine refuses are left out."""
    found = []
    for pair in pairs:
        try:
            divergence = measured(settings, pair.first, pair.second, pair)
        except CasrError:
            continue
        found.append(float(percent_error(divergence, pair.divergence)))
    return found


def measured(settings: FlowSettings, first: Grey, second: Grey, pair: FlowPair) -> float:
    """Divergence of the contact of ``pair`` from one frame to the other, per frame pair."""
    tracker = FlowTracker(settings)
    tracker.start(first, Region(pair.contact.polygon_px()))
    return tracker.step(second).divergence


def mean_sd(values: list[float]) -> list[Cell]:
    """Mean and standard deviation, or nothing where there are none."""
    return [float(np.mean(values)), sample_sd(np.array(values))] if values else [None, None]
