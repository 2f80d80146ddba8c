"""Does the energy of a dome that sticks balance, if what it takes to set holds is counted?

``python -m benchmarks.hold_energy | python -m benchmarks.bench.record hold_energy``: twenty seconds of one process.

After a step of the solver each point of the skin that came into touch is held to where its gap closed. That moves the
skin at the same depth: the flange does no work meanwhile, and the stored energy changes. Here each step begins with
this motion, whose energy is counted, and the force of the flange is integrated by Lobatto's rule over the rest of it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from casr.dome.solver.bodies import Rubber
from casr.dome.solver.contact import Opposite
from casr.dome.solver.press import FIRST_MM, GROWTH, Dome, Pressing, Specimen, _held, _World, press

CASE = Pressing(Dome(20.0, 1.0, Rubber(0.8), Rubber(0.03)), Specimen(None), np.inf, force_n=1.0, mesh_mm=1.0)
_Found = tuple[np.ndarray, float, float, Opposite]
STEPS_MM = (0.12, 0.06)
_WITHIN, _WEIGHT = (0.5 - 5**-0.5 / 2, 0.5 + 5**-0.5 / 2, 1.0), np.array([1, 5, 5, 1]) / 12


def balance(pressing: Pressing) -> tuple[float, float, float]:
    """Of the stored energy, what the work has too much; the same if what setting holds changes is counted at the old
    displacements; and if it is counted after the skin has come to rest."""
    world = _World(pressing)
    contact = world.contact
    moved, held = np.zeros(world.bodies.size), np.full(contact.size, np.nan)
    grip = contact.grip(contact.opposite(moved), held, np.inf)
    moved[world.specimen] -= FIRST_MM
    depth = length = FIRST_MM
    start, (moved, force, _, now) = contact.opposite(0 * moved), _solved(world.solved(moved, grip))
    first = stored = world.energy(moved, grip, now)
    work = set_before = set_after = 0.0
    slope = 0 * moved
    while force < pressing.force_n:
        held = _held(contact, grip, start, now)
        grip, start, before = contact.grip(now, held, np.inf), now, moved
        set_before += world.energy(moved, grip, now) - stored
        moved, force, _, now = _solved(world.solved(moved, grip))
        set_after += world.energy(moved, grip, now) - stored
        forces, done = [force], 0.0
        for share in _WITHIN:
            guess = moved + slope * (share - done) * length
            guess[world.driven] = -(depth + share * length)
            found = world.solved(guess, grip)
            if found is None:
                guess = moved.copy()
                guess[world.specimen] -= (share - done) * length
                found = _solved(world.solved(guess, grip))
            moved, force, _, now = found
            forces.append(force)
            done = share
        work += length * float(_WEIGHT @ forces)
        stored = world.energy(moved, grip, now)
        slope = (moved - before) / length
        depth += length
        length = min(length * GROWTH, pressing.step_mm)
    of_all = stored - first
    return tuple((work + each) / of_all - 1 for each in (0.0, set_before, set_after))  # type: ignore[return-value]


def _solved(found: _Found | None) -> _Found:
    assert found is not None
    return found


def rows() -> Iterator[str]:
    yield "| longest step (mm) | as a table states it | nothing counted | at the old displacements | at rest |"
    yield "|---:|" + "---:|" * 4
    for step in STEPS_MM:
        case = replace(CASE, step_mm=step)
        counted = " | ".join(f"{each:+.0e}" for each in balance(case))
        yield f"| {step:g} | {press(case).unstored:.0e} | {counted} |"


def main() -> None:
    print("# Energy of a dome that sticks\n")
    print("Work of the flange over stored energy, less 1, of dome A on a rigid plate to 1 N, elements of 1 mm; what it")
    print("takes to set new holds is counted in three ways:\n")
    for row in rows():
        print(row, flush=True)


if __name__ == "__main__":
    main()
