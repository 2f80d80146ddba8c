"""Virtual sensors identified from presses of three known specimens, against the truth.

Places of pins are made as in ``benchmarks.kappa``, by domes that the library which identifies does not hold.
``python -m benchmarks.sensor | python -m benchmarks.bench.record sensor``: four minutes.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from benchmarks.kappa import CAMERA, FORCES_N, N_FRAMES, N_REST, library_without, pressed, world_on
from casr.dome.library import MODULI_MPA, Library, shipped
from casr.dome.view import DomeView
from casr.kappa.family import Family
from casr.kappa.presses import KappaPress
from casr.kappa.sensor import QUANTITIES, IdentifiedSensor, identify_sensor
from emg2vsa.worlds.tactile import TACTIP_127

Array = NDArray[np.float64]

POLE_MM, PIN_MM, DEPTH = 2.0, 0.4, 0.03
"Most that a sensor differs by from what camera.toml says."
KNOWN = (1.1, 3.35, 7.63)
TILT_SD_DEG, LATTICE_SD_MM, LANDING_SD_MM, NOISE_PX = 2.0, 0.3, 0.5, 0.05
DEPTH_OF_MOUNTING, STIFFNESS_SD, AREA_SD, FORCE_ZERO_SD_N, FORCE_SD_N = 0.005, 0.02, 0.01, 0.005, 0.003


class World(NamedTuple):
    """A dome, or the middle between two in ``between``; left_out : of the library that identifies it."""

    name: str
    domes: tuple[str, ...]
    left_out: str
    stick: float


WORLDS = (
    World("J, left out", ("J",), "J", 1.0),
    World("H, left out", ("H",), "H", 0.0),
    World("E, left out", ("E",), "E", 1.0),
    World("I, left out", ("I",), "I", 0.0),
    World("between H and D", ("H", "D"), "", 1.0),
)


@dataclass(frozen=True)
class Sensor:
    """presses, and what is true of them, by ``QUANTITIES``."""

    presses: list[KappaPress]
    true: dict[str, float]
    library: Library


def sensor(world: World, seed: int, known: tuple[float, ...] = KNOWN) -> Sensor:
    """Of a world, with two or three presses of each known specimen in one mounting of it."""
    rng = np.random.default_rng([seed, *world.name.encode()])
    draw = rng.standard_normal
    away_px = rng.uniform(0, POLE_MM) * CAMERA.fx_px / CAMERA.depth_mm * np.array(_round(rng.uniform(0, 2 * np.pi)))
    pole_px = (float(CAMERA.cx_px + away_px[0]), float(CAMERA.cy_px + away_px[1]))
    pin_mm, depth_mm = 3.0 + rng.uniform(-PIN_MM, PIN_MM), CAMERA.depth_mm * (1 + rng.uniform(-DEPTH, DEPTH))
    family = Family(shipped(), world.domes)
    place = 0.5 if len(world.domes) == 2 else 0.0
    log_skin, log_gel = np.log([MODULI_MPA[dome] for dome in world.domes]).T
    presses = []
    for stiffness in known:
        factor, area = np.exp(STIFFNESS_SD * draw()), np.exp(AREA_SD * draw())
        view = DomeView(
            focal_px=(CAMERA.fx_px, CAMERA.fy_px), pole_px=pole_px, pin_length_mm=pin_mm,
            depth_mm=float(depth_mm * np.exp(DEPTH_OF_MOUNTING * draw())),
        )  # fmt: skip
        of_world = world_on(family, place, float(stiffness * factor), world.stick)
        tilt, lattice = np.deg2rad(TILT_SD_DEG) * draw(2), LATTICE_SD_MM / CAMERA.mm_per_px[0] * draw(2)
        rest_px = TACTIP_127.pins_px((pole_px[0] + lattice[0], pole_px[1] + lattice[1]))
        for _ in range(int(rng.integers(2, 4))):
            axis = np.append(tilt + LANDING_SD_MM / 20 * draw(2), 1.0)
            force_n = np.linspace(*FORCES_N, N_FRAMES)
            pins_px = pressed(view, rest_px, axis, of_world, family, force_n, float(area))
            presses.append(
                KappaPress(
                    rest_px=rest_px + NOISE_PX / np.sqrt(N_REST) * draw(rest_px.shape),
                    pins_px=pins_px + NOISE_PX * draw(pins_px.shape),
                    rest_frames=N_REST,
                    force_n=force_n + FORCE_ZERO_SD_N * draw() + FORCE_SD_N * draw(N_FRAMES),
                    specimen=f"{stiffness:g}",
                    mounting=f"{stiffness:g}",
                    stiffness_n_per_mm=stiffness,
                )
            )
    ratio, skin = family.at(place, log_gel - log_skin), _log_skin(family, place, log_skin)
    true = dict(zip(QUANTITIES, (*pole_px, pin_mm, depth_mm, *np.exp([ratio, skin, skin + ratio])), strict=True))
    return Sensor(presses, true, library_without(world.left_out))


def _log_skin(family: Family, place: float, log_skin: Array) -> float:
    """Of a dome between two, whose stiffness lies between theirs as each is for its skin."""
    return family.log_kappa0_at(place) - family.at(place, family.log_kappa0 - log_skin)


def _round(angle: float) -> tuple[float, float]:
    return float(np.cos(angle)), float(np.sin(angle))


def errors(found: IdentifiedSensor, true: dict[str, float]) -> Array:
    """(7,) of what was found, in standard errors."""
    return np.array([(each.value - true[name]) / each.sd for name, each in found.quantities.items()])


def tables(n_repetitions: int, seed: int) -> Iterator[str]:
    yield "# Sensors identified against the truth"
    yield ""
    yield (
        f"Each sensor is another one than camera.toml says: pole by up to {POLE_MM:g} mm, pin length {PIN_MM:g} mm, "
        f"depth {100 * DEPTH:g} %. Known specimens: {', '.join(f'{each:g}' for each in KNOWN)} N/mm, each mounted once "
        "(2 % of its stiffness, 0.5 % of depth, 1 % of area, 2 degrees of tilt) and pressed two or three times, 40 "
        "frames. Dome not in the library that identifies, or between two that are."
    )
    yield ""
    yield "Found ± standard error (true):"
    yield ""
    yield f"| sensor | {' | '.join(QUANTITIES)} | misfit before | after |"
    yield f"|---|{'---:|' * (len(QUANTITIES) + 2)}"
    every: list[Array] = []
    away: list[Array] = []
    for n in range(n_repetitions):
        for world in WORLDS:
            made = sensor(world, seed + n)
            found = identify_sensor(made.presses, CAMERA, library=made.library)
            every.append(errors(found, made.true))
            away.append(np.array([each.value - made.true[name] for name, each in found.quantities.items()]))
            if n == 0:
                cells = [
                    f"{each.value:.4g} ± {each.sd:.2g} ({made.true[name]:.4g})"
                    for name, each in found.quantities.items()
                ]
                yield f"| {world.name} | {' | '.join(cells)} | {found.misfit_before:.3f} | {found.misfit:.3f} |"
    off = np.array(every)
    yield ""
    yield f"All {len(off)} sensors, each world {n_repetitions} times, seeds from {seed}:"
    yield ""
    yield "| quantity | error, rms, in standard errors | within 1.96 standard errors, % | error, median size |"
    yield "|---|---:|---:|---:|"
    for name, column, sizes in zip(QUANTITIES, off.T, np.array(away).T, strict=True):
        rms, held = np.sqrt((column**2).mean()), 100 * (np.abs(column) < 1.96).mean()
        yield f"| {name} | {rms:.2f} | {held:.0f} | {np.median(np.abs(sizes)):.2g} |"


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repetitions", type=int, default=6, metavar="N")
    parser.add_argument("--seed", type=int, default=100, metavar="N")
    asked = parser.parse_args()
    for line in tables(asked.repetitions, asked.seed):
        print(line, flush=True)
