"""Is kappa of a specimen on another dome right, with tables of its own by ``casr dome``?

``python -m benchmarks.own_kappa FOLDER | python -m benchmarks.bench.record own_kappa``: the tables and rendered presses
of ``own_dome``, whose folder it takes. Each sensor presses 1.8 and 7.6 N/mm, that are
known, and 4.5 N/mm with and without friction, which is asked: one press of each, each its own mounting.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from benchmarks.own_dome import CHANGED, THIN, USUAL, presses, tables
from benchmarks.tactile.press_scores import rendered
from casr.dome.library import tables as library_of
from casr.errors import CasrError
from casr.kappa.estimate import estimate_kappa
from casr.kappa.posterior import Kappa
from casr.kappa.presses import KappaPress
from casr.scored import ScoreSettings
from casr.scoring import score

ASKED = 4.5
"N/mm"
WITHIN = 0.08

_HEAD = f"""# Kappa on other domes, with tables of their own

{{sensors}} sensors a row, each with presses of 1.8 and 7.6 N/mm, which are known, and of {ASKED} N/mm, which is asked,
with and without friction: one rendered press of each, from tables of another mesh and a stiffer contact. Interval: of
95 %. The domes that come with casr stand beside the own one; the better fit counts.

| changed | tables | told | within {100 * WITHIN:.0f} % | error (%) | held | half width (%) | misfit |
|---|---|---:|---:|---:|---:|---:|---:|"""


def kappas(folder: Path, changed: str, sensors: int) -> Iterator[str]:
    """A row by the tables that come with casr, one with own ones beside them."""
    name, changes = CHANGED[changed]
    height_mm = float((USUAL | changes)["height"]) if changed == THIN else None
    made = list(presses(folder, changed, sensors))
    frames = [rendered(each) for each in made]
    camera = frames[0].camera
    assert camera is not None
    for of, where, height in (("shipped", None, None), ("own", str(tables(folder, changed, "own")), height_mm)):
        settings, library = ScoreSettings(domes=where, specimen_height_mm=height), library_of(where, height)
        found: list[tuple[Kappa, float]] = []
        for sensor in range(sensors):
            of_sensor = range(sensor, len(made), sensors)
            try:
                pressed = []
                for row, at in enumerate(of_sensor):
                    stiffness = made[at].settings.stiffness_n_per_mm
                    known = None if stiffness == ASKED else stiffness
                    one = KappaPress.of_score(
                        score(frames[at], settings), specimen=f"{stiffness:g} {row}", mounting=str(row),
                        stiffness_n_per_mm=known,
                    )  # fmt: skip
                    pressed.append(one)
                result = estimate_kappa(pressed, camera, library=library)
            except CasrError:
                continue
            found += [(each, result.misfit) for each in result.kappas.values() if each.known is None]
        error = np.array([each.value / ASKED - 1 for each, _ in found])
        half = [(each.high - each.low) / 2 / each.value for each, _ in found]
        cells = [
            f"{len(found)} of {2 * sensors}", f"{np.mean(np.abs(error) <= WITHIN):.0%}",
            f"{100 * error.mean():+.1f} ± {100 * error.std(ddof=1):.1f}",
            f"{sum(each.low <= ASKED <= each.high for each, _ in found)} of {len(found)}",
            f"{100 * np.median(half):.0f}", f"{np.median([misfit for _, misfit in found]):.3f}",
        ]  # fmt: skip
        yield f"| {name} | {of} | {' | '.join(cells)} |"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--sensors", type=int, default=8)
    given = parser.parse_args()
    print(_HEAD.format(sensors=given.sensors), flush=True)
    for changed in CHANGED:
        print("\n".join(kappas(given.folder, changed, given.sensors)), flush=True)


if __name__ == "__main__":
    main()
