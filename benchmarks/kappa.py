"""``casr bench kappa``: kappa of an unknown specimen by the pins, on domes that the tables do not hold.

Places of pins are made without images, from the tables of one dome after the other, which is left out of the library
that explains them. Between its stiffnesses a dome's own tables are joined by cubic splines.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import cache
from itertools import product
from multiprocessing import get_context
from time import process_time

import numpy as np
from numpy.typing import NDArray

from benchmarks.tactile.table import Cell, Table
from casr.camera import Camera
from casr.dome.library import FAMILY, Library, shipped
from casr.dome.view import DomeView
from casr.errors import CasrError
from casr.kappa.discrepancy import Discrepancy
from casr.kappa.estimate import estimate_kappa
from casr.kappa.family import Family, World
from casr.kappa.known import CUES
from casr.kappa.posterior import Kappa
from casr.kappa.presses import KappaPress
from emg2vsa.worlds.tactile import TACTIP_127
from emg2vsa.worlds.tactile.settings import SIMULATED_SENSOR

Array = NDArray[np.float64]

DESIGNS = (
    ((1.1, 3.35, 7.63), 5.32),
    ((1.1, 3.35, 7.63), 2.0),
    ((1.5, 5.0, 10.0), 3.0),
    ((2.0, 4.0, 8.0), 6.5),
)
"Stiffness of three known specimens and of the unknown one, N/mm."
FRICTIONS, NOISES_PX, SCATTERS = {"stick": 1.0, "frictionless": 0.0}, (0.05, 0.2), (0.0, 0.025, 0.043)
N_PRESSES = 2
"Of each specimen, in one mounting of it."
FORCES_N, N_FRAMES, N_REST = (0.4, 4.5), 40, 4
PIN_LENGTH_SD_MM, DEPTH_SD, TILT_SD_DEG, LATTICE_SD_MM, LANDING_SD_MM = 0.05, 0.01, 2.0, 0.3, 0.5
FORCE_ZERO_SD_N, FORCE_SD_N = 0.005, 0.003
OF_SCATTER = {"depth": 0.4, "stiffness": 0.8, "area": 0.6}
"Shares of a mounting's scatter of CASR: as 1 % of depth, 2 % of stiffness and 1.5 % of area make 2.5 %."
CAMERA = Camera(sensor=SIMULATED_SENSOR)


@dataclass(frozen=True)
class Trial:
    """dome : left out. stick : share of friction. noise_px : of a pin. scatter : of CASR by mountings."""

    dome: str
    stick: float
    noise_px: float
    scatter: float
    known: tuple[float, ...]
    unknown: float
    seed: int


@dataclass(frozen=True)
class Outcome:
    """kappa : None where refused. cpu_s : of a press."""

    trial: Trial
    kappa: Kappa | None
    cpu_s: float
    refused: str = ""

    @property
    def log_error(self) -> float:
        assert self.kappa is not None
        return float(np.log(self.kappa.value / self.trial.unknown))

    @property
    def held(self) -> bool:
        assert self.kappa is not None
        return self.kappa.low <= self.trial.unknown <= self.kappa.high

    @property
    def half_width(self) -> float:
        assert self.kappa is not None
        return (self.kappa.high - self.kappa.low) / (2 * self.kappa.value)


@cache
def library_without(dome: str) -> Library:
    """The tables of casr but those of one dome."""
    library = shipped()
    return library.only(np.flatnonzero(library.dome != dome))


@cache
def _alone(dome: str) -> Family:
    return Family(shipped(), (dome,))


def presses_of(trial: Trial) -> list[KappaPress]:
    """Of all specimens of a trial."""
    rng = np.random.default_rng([trial.seed, *trial.dome.encode(), int(100 * trial.unknown)])
    draw = rng.standard_normal
    sensor_depth, pin_mm = float(np.exp(DEPTH_SD * draw())), 3.0 + PIN_LENGTH_SD_MM * float(draw())
    family = _alone(trial.dome)
    presses = []
    for stiffness in (*trial.known, trial.unknown):
        depth, factor, area = (float(np.exp(trial.scatter * OF_SCATTER[each] * draw())) for each in OF_SCATTER)
        view = DomeView(
            focal_px=(CAMERA.fx_px, CAMERA.fy_px), pole_px=(CAMERA.cx_px, CAMERA.cy_px),
            depth_mm=CAMERA.depth_mm * sensor_depth * depth, pin_length_mm=pin_mm,
        )  # fmt: skip
        world = world_on(family, 0.0, stiffness * factor, trial.stick)
        tilt, lattice = np.deg2rad(TILT_SD_DEG) * draw(2), LATTICE_SD_MM / CAMERA.mm_per_px[0] * draw(2)
        rest_px = TACTIP_127.pins_px((view.pole_px[0] + lattice[0], view.pole_px[1] + lattice[1]))
        for _ in range(N_PRESSES):
            axis = np.append(tilt + LANDING_SD_MM / 20 * draw(2), 1.0)
            force_n = np.linspace(*FORCES_N, N_FRAMES)
            pins_px = pressed(view, rest_px, axis, world, family, force_n, area)
            presses.append(
                KappaPress(
                    rest_px=rest_px + trial.noise_px / np.sqrt(N_REST) * draw(rest_px.shape),
                    pins_px=pins_px + trial.noise_px * draw(pins_px.shape),
                    rest_frames=N_REST,
                    force_n=force_n + FORCE_ZERO_SD_N * draw() + FORCE_SD_N * draw(N_FRAMES),
                    specimen=f"{stiffness:g}",
                    mounting=f"{stiffness:g}",
                    stiffness_n_per_mm=None if stiffness == trial.unknown else stiffness,
                )
            )
    return presses


def world_on(family: Family, place: float, stiffness: float, stick: float) -> World:
    """A dome at a place of a family on a specimen, N/mm; inf: a rigid plate."""
    log_kappa0 = family.log_kappa0_at(place)
    return family.world(place, float(1 / (1 + stiffness / np.exp(log_kappa0))), stick, log_kappa0)


def pressed(
    view: DomeView, rest_px: Array, axis: Array, world: World, family: Family, force_n: Array, area: float
) -> Array:
    """(T, N, 2) pins at forces (T,). axis : (3,) of the contact. area : what it is more or less than in the tables."""
    radius_mm = np.exp(np.interp(np.log(force_n), family.log_force(world), np.log(family.radius_mm))) * np.sqrt(area)
    around = view.around(view.directions(rest_px), axis / np.linalg.norm(axis))
    place = np.clip((radius_mm - family.radius_mm[0]) / (family.radius_mm[1] - family.radius_mm[0]), 0, None)
    row = np.minimum(place.astype(np.intp), family.radius_mm.size - 2)
    share = (place - row)[:, None, None]
    profile = family.motion(world.motion)
    of_frames = profile[row] * (1 - share) + profile[row + 1] * share
    motion = np.array([[np.interp(around.arc_mm, family.arc_mm, each[:, k]) for each in of_frames] for k in range(3)])
    return np.asarray(rest_px + around.moved_px(*motion.transpose(0, 2, 1)).transpose(2, 0, 1))


def tried(trial: Trial) -> Outcome:
    """Presses of a trial made and estimated."""
    presses = presses_of(trial)
    stated = Discrepancy().mounted(trial.scatter)
    start = process_time()
    try:
        found = estimate_kappa(presses, CAMERA, library=library_without(trial.dome), discrepancy=stated)
    except CasrError as error:
        return Outcome(trial, None, 0.0, str(error))
    return Outcome(trial, found.kappas[f"{trial.unknown:g}"], (process_time() - start) / len(presses))


def trials(n_repetitions: int, seed: int = 0) -> list[Trial]:
    """All of the benchmark; seed : of the first. Each has its own: trials alike in all but noise would else have the
    same mountings, and 112 of them would be 28."""
    ways = product(FAMILY, FRICTIONS.values(), NOISES_PX, SCATTERS, DESIGNS, range(n_repetitions))
    return [Trial(*way[:4], *way[4], seed + k) for k, way in enumerate(ways)]


def outcomes(every: Sequence[Trial], n_jobs: int) -> Iterator[Outcome]:
    """Of trials, in their order."""
    if n_jobs == 1:
        yield from map(tried, every)
        return
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    with ProcessPoolExecutor(n_jobs, mp_context=get_context("spawn")) as pool:
        yield from pool.map(tried, every, chunksize=4)


COLUMNS = (
    ("presses", ""), ("n", ".0f"), ("refused %", ".0f"), ("median %", "+.1f"), ("bias %", "+.1f"), ("sd %", ".1f"),
    ("half %", ".1f"), ("held %", ".0f"), ("told %", ".0f"), ("held, told %", ".0f"), ("bound %", ".1f"),
    ("efficiency", ".2f"), ("pins sd %", ".1f"), ("force sd %", ".1f"), ("cpu ms", ".0f"),
)  # fmt: skip
NOTES = (
    "Kappa of one unknown specimen beside three known ones (1.1 to 10 N/mm, two presses each, 40 frames of 0.4 to",
    "  4.5 N, 127 pins; off by SD: pin length 0.05 mm, depth 1 %, tilt 2 degrees, lattice 0.3 mm), the dome left out.",
    "median, bias, sd: of ln(kappa / true). half: median half width of the 95 % interval. held: it holds the truth.",
    "told: called determined, by the design. bound: Cramer and Rao's for white noise of pins with the same quantities",
    "  free; efficiency: bound over standard error stated, median. scatter: of CASR, from mounting to mounting.",
    "The estimate is told how far mountings scatter, as a study tells it ([calibration] mounting_sd_percent).",
    "pins sd, force sd: median standard error by one cue alone; - where it tells nothing.",
)


def page(every: int, n_jobs: int, seed: int) -> Iterator[str]:
    """Markdown of the table, for ``benchmarks/results/kappa.json``, by each so-manieth trial."""
    table = _table(list(outcomes(trials(1, seed)[::every], n_jobs)))
    yield f"# {table.title}"
    yield ""
    yield f"{' '.join(note.strip() for note in NOTES)} Of {len(trials(1))} trials each {every}th was made, seed {seed}."
    yield ""
    yield f"| {' | '.join(heading for heading, _ in COLUMNS)} |"
    yield f"|---|{'---:|' * (len(COLUMNS) - 1)}"
    for row in table.rows:
        cells = zip(row, COLUMNS, strict=True)
        yield f"| {' | '.join('-' if cell is None else format(cell, form) for cell, (_, form) in cells)} |"


def kappa_tables(n_repetitions: int, n_jobs: int) -> list[Table]:
    """Bias, width, coverage and efficiency, by what differs."""
    return [_table(list(outcomes(trials(n_repetitions), n_jobs)))]


def _table(found: Sequence[Outcome]) -> Table:
    groups: dict[str, list[Outcome]] = {}
    for each in found:
        t = each.trial
        friction = next(name for name, stick in FRICTIONS.items() if stick == t.stick)
        design = f"{', '.join(f'{known:g}' for known in t.known)} -> {t.unknown:g}"
        for name in (f"dome {t.dome}", friction, f"{t.noise_px:g} px, scatter {100 * t.scatter:g} %", design, "(all)"):
            groups.setdefault(name, []).append(each)
    order = sorted(groups, key=lambda name: (name == "(all)", "->" in name, "px" in name, not name.startswith("dome")))
    groups = {name: groups[name] for name in order}
    rows = [_row(name, each) for name, each in groups.items()]
    return Table("kappa", "Kappa by the pins, one dome left out at a time", COLUMNS, rows, NOTES)


def _row(name: str, every: Sequence[Outcome]) -> list[Cell]:
    told = [each for each in every if each.kappa is not None]
    refused = 100 * (1 - len(told) / len(every))
    if not told:
        return [name, float(len(every)), refused, *[None] * 12]
    errors = 100 * np.array([each.log_error for each in told])
    kappas = [each.kappa for each in told if each.kappa is not None]
    clear = [each for each in told if each.kappa is not None and each.kappa.determined]
    by_cue = [[kappa.by_cue.get(cue, (0, np.inf))[1] for kappa in kappas] for cue in CUES]
    numbers = [
        np.median(errors), errors.mean(), errors.std(), 100 * np.median([each.half_width for each in told]),
        100 * np.mean([each.held for each in told]), 100 * len(clear) / len(told),
        100 * np.mean([each.held for each in clear]) if clear else np.nan,
        100 * np.median([kappa.bound_sd for kappa in kappas]), np.median([kappa.efficiency for kappa in kappas]),
        *(100 * np.median(each) for each in by_cue), 1000 * np.median([each.cpu_s for each in told]),
    ]  # fmt: skip
    return [name, float(len(every)), refused, *(float(each) if np.isfinite(each) else None for each in numbers)]


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--every", type=int, default=1, metavar="N")
    parser.add_argument("--seed", type=int, default=0, metavar="N")
    parser.add_argument("--jobs", type=int, default=1, metavar="N")
    asked = parser.parse_args()
    print("\n".join(page(asked.every, asked.jobs, asked.seed)))
