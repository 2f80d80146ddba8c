"""Is a press of another dome, or on a thin specimen, scored rightly with tables of its own by ``casr dome``?

``python -m benchmarks.own_dome FOLDER | python -m benchmarks.bench.record own_dome``: twenty minutes of one process for
tables, which are kept in FOLDER, and four for presses. The presses are rendered from tables of the same solver: a finer
mesh, a stiffer contact, other stiffnesses. So this proves the way from sensor.toml to areas, and not the mechanics.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.tactile.press_scores import rendered
from casr.atomic import write_bytes_atomic
from casr.camera import Camera
from casr.dome.library import Library, of_height, read_library, with_between
from casr.dome.solver.cases import dome_radius_mm, said_of, table_file
from casr.dome.solver.press import press
from casr.dome.solver.sensor_file import Case, read_sensor
from casr.errors import CasrError
from casr.frames import FrameSequence
from casr.scored import ScoreSettings
from casr.scoring import score
from emg2vsa.worlds.tactile import (
    REALISTIC,
    Appearance,
    PressSettings,
    SimulatedPress,
    Skin,
    TabulatedWorld,
    simulate_press,
)
from emg2vsa.worlds.tactile.settings import SIMULATED_SENSOR

SENSOR = """
[dome]
name = "{what}"
radius_mm = {radius}
skin_mm = {skin}
skin_modulus_mpa = {modulus}
gel_modulus_mpa = {gel}
[specimen]
height_mm = {height}
stiffness_n_per_mm = {stiffness}
friction = {friction}
rigid = {rigid}
[solve]
force_n = {force}
mesh_mm = {mesh}
"""
USUAL = {"radius": 20, "skin": 1, "modulus": 0.8, "gel": 0.03, "height": 25, "heights": 25}
CHANGED = {
    "skin": ("skin of 1.5 mm", {"skin": 1.5}),
    "gel": ("gel of 5 kPa", {"gel": 0.005}),
    "radius": ("radius 25 mm", {"radius": 25}),
    "thin": ("specimens of 10 mm, tables of 7 and 14", {"height": 10, "heights": [7, 14]}),
    "stiff": ("skin 2.4 MPa, gel .1 MPa", {"modulus": 2.4, "gel": 0.1}),
}
THIN = "thin"
BETWEEN_N_PER_MM = 3.3039
"Halfway in compliance between 2.4 and 5.3, where the scorer has a world that lies between two tables."


_HEAD = """# Other domes and thin specimens, with tables of their own

Own tables: 1.1, 2.4, 5.3 and 20 N/mm and a rigid plate, two frictions, up to 5 N, a mesh of 0.8 mm. Their area at
3.30 N/mm, that sticks, against a solution of this stiffness with half the mesh, half the steps, four times the penalty:
"""
_PRESSES = """
Rendered presses from 0.5 to 7 N on 1.8, 4.5 and 7.6 N/mm that stick and 4.5 without friction, {repetitions} of each,
from tables of another mesh (0.7 mm), four times the penalty, up to 7.2 N. Each is another sensor and mounting: roots of
pins 0.2 mm off, tilt 2 degrees, depth 1 %, noise of 2, 5 or 10 grey levels. Scored by the tables of casr alone (the
camera file has the radius outside), and with own ones beside them. Of areas at 0.5, 1, 2 and 4 N those count that are
determined: a contact of less than 1.5 pitches is not. Refused: no front or no rate. Doubted: a reason is told to look
at the press. Interval: of 95 %.

| changed | tables | within 8 % | areas off (%) | refused | doubted | CASR off (%) | held | half width (%) | misfit |
|---|---|---:|---:|---:|---:|---:|---:|---:|---:|"""


@dataclass(frozen=True)
class Tables:
    """step_mm, penalty : of the solver."""

    stiffness: str
    friction: str
    force: float
    mesh: float
    step_mm: float = 0.12
    penalty: float = 1.0
    rigid: str = "false"


OWN = Tables("[1.1, 2.4, 5.3, 20]", '["stick", "frictionless"]', 5, 0.8, rigid="true")
WORLDS = (
    Tables("[1.8, 4.5, 7.6]", '["stick"]', 7.2, 0.7, penalty=4.0),
    Tables("[4.5]", '["frictionless"]', 7.2, 0.7, penalty=4.0),
)
FINER = Tables(f"[{BETWEEN_N_PER_MM}]", '["stick"]', 4.2, 0.4, step_mm=0.06, penalty=4.0)
PRESSED = ((1.8, "stick"), (4.5, "stick"), (7.6, "stick"), (4.5, "frictionless"))
FORCES_N = (0.5, 1.0, 2.0, 4.0)
NOISES_GREY = (2.0, 5.0, 10.0)
ROOTS_MM, TILT_DEG = 0.2, 2.0
WITHIN = 0.08


def tables(folder: Path, changed: str, what: str) -> Path:
    """The folder of ``own``, ``world`` or ``finer`` tables, solved where they are not there."""
    into = folder / changed / what
    for of in {"own": (OWN,), "world": WORLDS, "finer": (FINER,)}[what]:
        for case in cases(folder, changed, what, of):
            path = into / f"{case.name}.npz"
            if said_of(path).get("digest") != case.digest:
                into.mkdir(parents=True, exist_ok=True)
                write_bytes_atomic(path, table_file(case, press(case.pressing), {"digest": case.digest}))
    return into


def cases(folder: Path, changed: str, what: str, of: Tables) -> list[Case]:
    values = USUAL | CHANGED[changed][1] | vars(of) | {"what": what}
    values["height"] = values["heights"] if what == "own" else values["height"]
    file = folder / changed / f"{what}.toml"
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(SENSOR.format(**values), encoding="utf-8")
    read = read_sensor(file)
    return [replace(case, pressing=replace(case.pressing, step_mm=of.step_mm, penalty=of.penalty)) for case in read]


def solver(folder: Path) -> Iterator[str]:
    """Areas of own tables, at a stiffness between two, against a finer solution of this stiffness."""
    yield f"| changed | {' | '.join(f'area at {each:g} N, off (%)' for each in FORCES_N)} |"
    yield "|---|" + "---:|" * len(FORCES_N)
    for changed, (name, _) in CHANGED.items():
        own, finer = (read_library(tables(folder, changed, what)) for what in ("own", "finer"))
        if changed == THIN:
            own = of_height(own, float(finer.height_mm[0]))
        off = 100 * (areas(with_between(own)) / areas(finer) - 1)
        yield f"| {name} | {' | '.join(f'{each:+.1f}' for each in off)} |"


def areas(library: Library) -> NDArray[np.float64]:
    """At ``FORCES_N``, of the world that sticks to a specimen of ``BETWEEN_N_PER_MM``."""
    near = np.isclose(library.stiffness_n_per_mm, BETWEEN_N_PER_MM, rtol=1e-3)
    (row,) = np.flatnonzero(near & (library.friction == "stick"))
    radius = np.exp(np.interp(np.log(FORCES_N), np.log(library.force_n[row]), np.log(library.radius_mm)))
    return np.asarray(np.pi * radius**2)


@dataclass(frozen=True, kw_only=True)
class UnevenSkin(Skin):
    """Pins off the places of a grid. sd_px : standard deviation along each axis. seed : of the sensor."""

    sd_px: float
    seed: int

    def pins_px(self, centre_px: tuple[float, float]) -> NDArray[np.float64]:
        grid = super().pins_px(centre_px)
        return grid + np.random.default_rng(self.seed).normal(scale=self.sd_px, size=grid.shape)


def presses(folder: Path, changed: str, repetitions: int) -> Iterator[SimulatedPress]:
    values, where = USUAL | CHANGED[changed][1], str(tables(folder, changed, "world"))
    radius_mm = dome_radius_mm(cases(folder, changed, "world", WORLDS[0])[0])
    camera = Camera(sensor=replace(SIMULATED_SENSOR, dome_radius_mm=radius_mm))
    for stiffness, friction in PRESSED:
        for number in range(repetitions):
            yield simulate_press(
                PressSettings(
                    stiffness_n_per_mm=stiffness, repetition=number, mounting=number, camera=camera,
                    world=TabulatedWorld(tables=where, friction=friction),
                    specimen_height_mm=float(values["height"]),
                    scatter=replace(REALISTIC, angle_sd_deg=TILT_DEG, stiffness_sd=0.0),
                    skin=UnevenSkin(sd_px=ROOTS_MM * camera.fx_px / camera.depth_mm, seed=number, mask_radius_px=145.0),
                    appearance=Appearance(noise_grey=NOISES_GREY[number % len(NOISES_GREY)]),
                )
            )  # fmt: skip


def scored(folder: Path, changed: str, repetitions: int) -> Iterator[str]:
    """A row for the shipped tables, one with own ones beside them."""
    name, changes = CHANGED[changed]
    height_mm = float((USUAL | changes)["height"]) if changed == THIN else None
    own = ScoreSettings(domes=str(tables(folder, changed, "own")), specimen_height_mm=height_mm)
    found: dict[str, list[Outcome]] = {"shipped": [], "own": []}
    for made in presses(folder, changed, repetitions):
        frames = rendered(made)
        plain = with_radius(frames, float((USUAL | changes)["radius"]))
        found["shipped"].append(outcome(plain, ScoreSettings(), made))
        found["own"].append(outcome(frames, own, made))
    for tables_of, every in found.items():
        off = 100 * np.concatenate([each.area_off for each in every])
        known = off[np.isfinite(off)]
        casr = np.array([each.casr_off for each in every])
        casr = 100 * casr[np.isfinite(casr)]
        cells = [
            f"{np.mean(np.abs(known) <= 100 * WITHIN):.0%} of {known.size}", f"{known.min():+.1f} … {known.max():+.1f}",
            f"{sum(each.refused for each in every)} of {len(every)}",
            f"{sum(each.doubted for each in every)} of {len(every)}", f"{casr.mean():+.1f} ± {casr.std(ddof=1):.1f}",
            f"{sum(each.held for each in every)} of {casr.size}",
            f"{100 * np.nanmean([each.half for each in every]):.1f}",
            f"{np.nanmedian([each.misfit for each in every]):.3f}",
        ]  # fmt: skip
        yield f"| {name} | {tables_of} | {' | '.join(cells)} |"


def with_radius(frames: FrameSequence, radius_mm: float) -> FrameSequence:
    """As one scores who has no tables: the camera file says the radius outside."""
    camera = frames.camera
    assert camera is not None
    return replace(frames, camera=replace(camera, sensor=replace(camera.sensor, dome_radius_mm=radius_mm)))


@dataclass(frozen=True)
class Outcome:
    """area_off : at ``FORCES_N``, NaN where the area is not determined. casr_off, half : of CASR and of its interval, a
    share; NaN without one. held : the interval holds the truth. refused : there is no front or no rate. doubted : the
    press has doubts."""

    area_off: NDArray[np.float64]
    casr_off: float = np.nan
    half: float = np.nan
    held: bool = False
    refused: bool = True
    doubted: bool = False
    misfit: float = np.nan


def outcome(frames: FrameSequence, settings: ScoreSettings, made: SimulatedPress) -> Outcome:
    truth = made.truth
    try:
        found = score(frames, settings)
    except CasrError:
        return Outcome(np.full(len(FORCES_N), np.nan))
    at = [int(np.argmin(np.abs(truth.force_n[found.frames] - force))) for force in FORCES_N]
    off = found.area[at] / truth.area_mm2[found.frames[at]] - 1
    spread, true = found.front_spread, truth.casr_power_mm2_per_n
    if spread is None or spread.rate is None or spread.interval is None:
        return Outcome(off, doubted=bool(found.doubts), misfit=found.front.misfit)
    low, high = spread.interval.low, spread.interval.high
    return Outcome(
        off, spread.rate.value / true - 1, (high - low) / 2 / spread.rate.value, low <= true <= high, False,
        bool(found.doubts), found.front.misfit,
    )  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--repetitions", type=int, default=6)
    given = parser.parse_args()
    print(_HEAD, *solver(given.folder), sep="\n", flush=True)
    print(_PRESSES.format(repetitions=given.repetitions), flush=True)
    for changed in CHANGED:
        print("\n".join(scored(given.folder, changed, given.repetitions)), flush=True)


if __name__ == "__main__":
    main()
