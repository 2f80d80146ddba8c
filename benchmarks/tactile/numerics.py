"""``casr bench numerics``: where the arithmetic holds and what the scene does to the divergence.

How far each chain of engine and rules is off: in CASR, and in the stiffness it leads to.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import cycle, islice

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import curve_fit

from benchmarks.bench.measure import peak_so_far_mb, pin_loaded
from benchmarks.tactile.flow_pairs import FlowPair, contact_pair
from benchmarks.tactile.flow_scores import percent_error, sample_sd, worst
from benchmarks.tactile.press_scores import TRUE_AREA, Chain, PressScores
from benchmarks.tactile.table import Cell, Table
from casr.errors import CasrError
from casr.flow.estimate import ENGINES, FlowSettings, FlowTracker
from casr.flow.horn_schunck import HornSchunckSettings, horn_schunck
from casr.flow.region import Region
from casr.images import Grey
from casr.specimens import SPECIMENS
from emg2vsa.worlds.tactile import Appearance

CALIBRATION, UNKNOWN = ("S1", "S3", "S5"), "S2"
ANGLES_DEG = (0.0, 30.0, 45.0)
STIFFNESS_N_MM = np.array([SPECIMENS[name] for name in (*CALIBRATION, UNKNOWN)])


@dataclass(frozen=True)
class Judged:
    """A chain and its errors, percent: CASR of each press; kappa at each angle; see the notes of the table."""

    chain: Chain
    casr_percent: list[float]
    kappa_percent: list[float]
    added_percent: float
    left_out_percent: float

    @property
    def typical_casr_percent(self) -> float:
        """Median size of the error of CASR; infinite where a press gave none."""
        sizes = np.abs(self.casr_percent)
        return float("inf") if np.isnan(sizes).any() else float(np.median(sizes))


def judge(results: Sequence[PressScores], chain: Chain, exact_percent: Sequence[float]) -> Judged:
    """Errors of one chain, beside the errors of kappa that exact CASR leaves."""
    kappa, left_out = stiffness_errors(results, chain)
    added = [float(percent_error(100 + k, 100 + exact)) for k, exact in zip(kappa, exact_percent, strict=True)]
    return Judged(chain, casr_errors(results, chain), kappa, worst(added), worst(left_out))


def casr_errors(results: Sequence[PressScores], chain: Chain) -> list[float]:
    """Error of CASR on each press, percent."""
    return [float(percent_error(r.casr[chain], r.true_casr[chain[3]])) for r in results]


def stiffness_errors(results: Sequence[PressScores], chain: Chain | None) -> tuple[list[float], list[float]]:
    """Error on the unknown specimen at each angle, and on each in turn, percent. Chain None is true CASR."""
    unknown, left_out = [], []
    for angle in ANGLES_DEG:
        casr = _casr(results, chain, angle)
        unknown.append(unknown_error_percent(casr, STIFFNESS_N_MM, SPECIMENS[UNKNOWN]))
        left_out += [unknown_error_percent(casr, STIFFNESS_N_MM, stiffness) for stiffness in STIFFNESS_N_MM.tolist()]
    return unknown, left_out


def unknown_error_percent(casr: NDArray[np.float64], kappa_n_mm: NDArray[np.float64], unknown: float) -> float:
    """Error on the stiffness of one specimen, from the others' calibration at the mean CASR of its presses, percent.

    kappa = p exp(q CASR) by least squares in kappa (paper, section VI), from the straight line through ln kappa. casr :
    (n_specimens, n_repetitions), one angle. kappa_n_mm : (n_specimens,). unknown : one of these stiffnesses. NaN where
    CASR is the same for every press, or unknown for one.
    """
    hidden = kappa_n_mm == unknown
    x, kappa = casr[~hidden].ravel(), np.repeat(kappa_n_mm[~hidden], casr.shape[1])
    centre, spread = x.mean(), x.std()
    if not spread > 0:
        return float("nan")
    z = (x - centre) / spread  # scaled for the arithmetic, so that the unit of the scores does not matter
    slope, log_p = np.polyfit(z, np.log(kappa), 1)
    (p, q), _ = curve_fit(lambda z, p, q: p * np.exp(q * z), z, kappa, p0=(np.exp(log_p), slope), maxfev=10_000)
    return float(100 * (p * np.exp(q * (casr[hidden].mean() - centre) / spread) / unknown - 1))


def _casr(results: Sequence[PressScores], chain: Chain | None, angle_deg: float) -> NDArray[np.float64]:
    """(n_specimens, n_repetitions) CASR at one angle."""
    found = [
        [
            r.casr[chain] if chain else r.true_casr["power"]
            for r in results
            if r.angle_deg == angle_deg and r.stiffness_n_mm == stiffness
        ]
        for stiffness in STIFFNESS_N_MM.tolist()
    ]
    return np.array(found)


def recommendation(judged: Sequence[Judged]) -> str:
    """The chains that come out best by each measure."""
    usable = [j for j in judged if j.chain[1] != TRUE_AREA]
    kappa = min(usable, key=lambda j: worst(j.kappa_percent))
    added = min(usable, key=lambda j: j.added_percent)
    casr = min(usable, key=lambda j: j.typical_casr_percent)
    return (
        f"Least error of kappa at its worst angle: {', '.join(kappa.chain)} ({worst(kappa.kappa_percent):.1f} %); "
        f"least added: {', '.join(added.chain)} ({added.added_percent:.1f} %); "
        f"least median error of CASR: {', '.join(casr.chain)} ({casr.typical_casr_percent:.1f} %)."
    )


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
    pin_loaded()  # OpenCV on one thread, as the other methods are; processor time would add the threads up
    return [identical_table(), precision_table(), settings_table(n_seeds), scene_table(n_seeds), streaming_table()]


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
        before_mb, times_s = peak_so_far_mb(), []
        memory: list[Cell] = []
        for n_frames in STREAMED_FRAMES:
            times_s.append(_stream(tracker, islice(frames, n_frames)) / n_frames)
            memory.append(peak_so_far_mb() - before_mb)
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
