"""How much better is a press of another skin, or on a thin specimen, scored with tables of its own by ``casr dome``?

``python -m benchmarks.own_dome FOLDER | python -m benchmarks.bench.record own_dome``: ten minutes of one process for
tables, which are kept in FOLDER, and 40 s for presses. The presses are rendered from tables of the same solver: a finer
mesh, other stiffnesses. So this proves the way from sensor.toml to areas, and not the mechanics.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from benchmarks.tactile.press_scores import rendered
from casr.dome.solver.cases import solve
from casr.dome.solver.sensor_file import read_sensor
from casr.scored import ScoreSettings
from casr.scoring import score
from emg2vsa.worlds.tactile.files import PressPlan
from emg2vsa.worlds.tactile.press import simulate_press
from emg2vsa.worlds.tactile.tabulated import TabulatedWorld

SENSOR = """
[dome]
name = "{name}"
radius_mm = 20
skin_mm = {skin}
skin_modulus_mpa = 0.8
gel_modulus_mpa = 0.03
[specimen]
height_mm = {height}
stiffness_n_per_mm = {stiffness}
friction = {friction}
[solve]
force_n = 7.2
mesh_mm = {mesh}
"""
THICK = {"skin": 1.5, "height": 25}
TABLES = {
    "world": {**THICK, "stiffness": "[1.1, 3.35, 7.6, 20]", "friction": '["stick"]', "mesh": 0.5},
    "own": {**THICK, "stiffness": "[1.1, 2.4, 5.3, 20]", "friction": '["stick", "frictionless"]', "mesh": 0.8},
    "thin": {"skin": 1, "height": 10, "stiffness": "[1.1, 3.35, 7.6]", "friction": '["stick"]', "mesh": 0.8},
    "heights": {"skin": 1, "height": "[6, 16]", "stiffness": "[1.1, 2.4, 5.3, 20]", "friction": '["stick"]', "mesh": 1},
}
FORCES_N = (0.5, 1.0, 2.0, 4.0)


def tables(name: str, folder: Path) -> Path:
    """The folder of the tables, solved where they are not there."""
    folder.mkdir(parents=True, exist_ok=True)
    sensor = folder / f"{name}.toml"
    sensor.write_text(SENSOR.format(name=name, **TABLES[name]), encoding="utf-8")
    for solved in solve(read_sensor(sensor), folder / name, jobs=1):
        assert not solved.stopped
    return folder / name


def rows(folder: Path, repetitions: int, of_world: str, of_own: str, height_mm: float | None) -> Iterator[str]:
    world = TabulatedWorld(tables=str(tables(of_world, folder)), dome=of_world)
    own = ScoreSettings(domes=str(tables(of_own, folder)), specimen_height_mm=height_mm)
    heads = " | ".join(f"area at {each:g} N, off (%)" for each in FORCES_N)
    yield f"| specimen | tables | {heads} | CASR off (%) | misfit | presses with a doubt |"
    yield "|---|---|" + "---:|" * 7
    for specimen in ("S1", "S3", "S5"):
        plan = PressPlan(specimens=(specimen,), angles=(0.0,), repetitions=repetitions)
        presses = [simulate_press(replace(each, world=world)) for each in plan.presses().values()]
        for name, settings in (("shipped", ScoreSettings()), ("shipped and own", own)):
            found = []
            doubts = 0
            for press in presses:
                scored = score(rendered(press), settings)
                truth, frames = press.truth, scored.frames
                at = [int(np.argmin(np.abs(truth.force_n[frames] - force))) for force in FORCES_N]
                off = scored.front.area[at] / truth.area_mm2[frames[at]] - 1
                spread = scored.front_spread
                rate = spread.rate.value / truth.casr_power_mm2_per_n - 1 if spread and spread.rate else np.nan
                found.append([*100 * off, 100 * rate, scored.front.misfit])
                doubts += bool(scored.front_doubt)
            *percent, misfit = np.mean(found, axis=0)
            cells = [f"{each:+.1f}" for each in percent] + [f"{misfit:.3f}", f"{doubts} of {len(presses)}"]
            yield f"| {specimen} | {name} | {' | '.join(cells)} |"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--repetitions", type=int, default=3)
    given = parser.parse_args()
    print("# A skin of 1.5 mm, and specimens of 10 mm, scored with tables of their own\n")
    print("Mean error of rendered presses against their truth. Presses and tables are of one solver, with other meshes")
    print("(.5 and .8 mm) and stiffnesses. A skin of 1.5 mm:\n")
    print("\n".join(rows(given.folder, given.repetitions, "world", "own", None)))
    print("\nA skin of 1 mm on specimens of 10 mm, whose height is told; own tables of 6 and 16 mm:\n")
    print("\n".join(rows(given.folder, given.repetitions, "thin", "heights", 10.0)))


if __name__ == "__main__":
    main()
