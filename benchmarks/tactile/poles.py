"""Areas where the middle of the pins, the axis of the dome and the principal point of camera.toml are not one place.

Run with ``python -m benchmarks.tactile.poles [--write FILE]``, about a quarter of an hour of a processor. Frames are
rendered with noise and scored as ``casr score`` does; a dome of the library is missing from it while it is pressed.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import product

import numpy as np

from benchmarks.bench.record import print_page
from benchmarks.tactile.world_scores import FORCES_N, WorldScore, world_scored
from casr.contact_area.front import LEAST_PITCHES
from casr.specimens import SPECIMENS
from emg2vsa.worlds.tactile import TACTIP_127, PressSettings, TimelineSettings

PRESSED = tuple(SPECIMENS[name] for name in ("S1", "S3", "S5"))
LIKE, FAR = ("tabulated", "tabulated-frictionless"), ("dome-J-stick", "dome-D-stick", "dome-E-frictionless")
"Domes that lie between those of the library, and domes left out of it, in gaps of four times the gel's modulus."
OFF_MM, WRONG_PX = (0.0, 0.6, 1.0, 2.0, 3.0), (5.0, 20.0)
REPETITIONS = 3
WITHIN = 8.0
"Percent of the area."


def main() -> None:
    """Print both tables."""
    print_page(__doc__, _page)


def pressed(world: str, kappa: float, repetition: int, off_mm: float, wrong_px: float, angle_deg: float) -> WorldScore:
    """A press with the lattice so far off its dome, and cx_px and cy_px of camera.toml so far off the image's."""
    turn = 2.4 * repetition + kappa
    toward = np.array([np.cos(turn), np.sin(turn)])
    plain = PressSettings(stiffness_n_per_mm=kappa, repetition=repetition, angle_deg=angle_deg)
    x, y = (off_mm / plain.camera.mm_per_px[0] * toward).tolist()
    settings = replace(
        plain, skin=replace(TACTIP_127, off_px=(x, y), mask_radius_px=146.0),
        timeline=TimelineSettings(peak_n=5.0, loading_s=2.0),
    )  # fmt: skip
    cx_px, cy_px = (np.array([plain.camera.cx_px, plain.camera.cy_px]) + wrong_px * toward).tolist()
    return world_scored(world, settings, replace(plain.camera, cx_px=cx_px, cy_px=cy_px), LEAST_PITCHES)


def _page() -> Iterator[str]:
    yield "# Pins that do not stand about the axis of their dome"
    yield ""
    yield f"`python -m benchmarks.tactile.poles`: {len(PRESSED)} specimens in each world, {REPETITIONS} presses each."
    yield f"Areas: 5 to 95 % of the errors, where the true radius is {LEAST_PITCHES:g} pitches or more. CASR: mean and"
    yield f"SD of the error. Like: {', '.join(LIKE)}. Far: {', '.join(FAR)}, each left out of the library."
    yield ""
    head = ["case", "presses", "refused", *(f"A({force:g} N) %" for force in FORCES_N)]
    head += [f"within {WITHIN:g} %, %", "CASR %", "held %", "doubts of the dome", "largest misfit", "pole told"]
    yield f"| {' | '.join(head)} |"
    yield "|---|" + "---:|" * (len(head) - 1)
    for worlds, name in ((LIKE, "like"), (FAR, "far")):
        for off_mm in OFF_MM:
            yield _row(f"{name}, lattice {off_mm:g} mm off", worlds, off_mm, 0.0, 0.0)
    for wrong_px in WRONG_PX:
        yield _row(f"like, cx and cy {wrong_px:g} px wrong", LIKE, 0.0, wrong_px, 0.0)
    yield _row("like, at 30°, lattice 2 mm off", LIKE, 2.0, 0.0, 30.0)
    yield _row("like, at 30°, cx and cy 20 px wrong", LIKE, 0.0, 20.0, 30.0)


def _row(name: str, worlds: tuple[str, ...], off_mm: float, wrong_px: float, angle_deg: float) -> str:
    each = product(worlds, PRESSED, range(REPETITIONS))
    found = [pressed(world, kappa, k, off_mm, wrong_px, angle_deg) for world, kappa, k in each]
    scored = [one for one in found if not one.refused]
    errors = {force: np.array([one.area_error_percent.get(force, np.nan) for one in scored]) for force in FORCES_N}
    every = np.concatenate(list(errors.values()))
    casr = np.array([100 * (one.front.value / one.true_casr - 1) for one in scored])
    held = np.mean([one.front.holds(one.true_casr) for one in scored])
    doubted = sum(any("every dome of the library" in doubt for doubt in one.doubts) for one in found)
    told = sum(any("axis of the dome" in note for note in one.notes) for one in found)
    cells = [name, str(len(found)), str(len(found) - len(scored)), *map(_range, errors.values())]
    cells.append(f"{100 * np.mean(np.abs(every[np.isfinite(every)]) <= WITHIN):.0f}")
    cells += [f"{casr.mean():+.1f} ± {casr.std():.1f}", f"{100 * held:.0f}", str(doubted)]
    cells += [f"{max(one.misfit for one in scored):.3f}", str(told)]
    return f"| {' | '.join(cells)} |"


def _range(errors: np.ndarray) -> str:
    known = errors[np.isfinite(errors)]
    return f"{np.quantile(known, 0.05):+.1f} … {np.quantile(known, 0.95):+.1f}" if known.size else "–"


if __name__ == "__main__":
    main()
