"""Is the softness of real silicone what was published, and do intervals of kappa hold for other presses and castings?

``python -m benchmarks.silicone PHANTOMS | python -m benchmarks.bench.record silicone``: a minute of one process.
PHANTOMS: compressions of real silicone, a folder a mixture (Dawood et al. 2026, CC BY 4.0).
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from emg2vsa.arrays import Floats
from emg2vsa.curves.force_range import fit_range, loading
from emg2vsa.curves.plate_tests import PlateTests, SpecimenPlates
from emg2vsa.curves.rubber import Cylinder
from emg2vsa.curves.specimen_kappa import LEVELS, NestedMean, Spread, nested_mean
from emg2vsa.rig_file.plate_logs import Asked, read_plates
from emg2vsa.rig_file.silicone_kit import SILICONES, kappa_of

KAPPA = 5.0
COUNTS = ((1, 1, 1), (5, 1, 1), (5, 3, 1), (5, 1, 2), (3, 2, 4), (1, 6, 1))
TIMES = (0.5, 1.0, 1.4)
BLOCK, DRAWS = 0.05, 400


def moduli(plates: PlateTests) -> Iterator[str]:
    head = (
        "mixture | published (kPa) | here | 95 % interval ± | off (%) | within 6.5 % or 2 published SD | interval holds"
    )
    more = "κ (N/mm) | ± (%) | change (%) | law that fits best | left (mN) | line leaves (mN) | κ of the kit | off (%)"
    yield f"| {head} | {more} |"
    yield "|---|" + "---:|" * 14
    off_kappa = []
    for silicone in SILICONES:
        name, published, sd = silicone.name, silicone.modulus_kpa, silicone.sd_kpa
        of = plates.specimen(name)
        assert of is not None
        assert of.modulus is not None
        off, half = of.modulus.mean / published - 1, of.modulus.half()
        left = {each.law: 1e3 * each.left_n for each in of.laws}
        cells = [f"{published} ± {sd}", f"{of.modulus.mean:.2f}", f"{half:.2f}", f"{100 * off:+.1f}"]
        cells += ["yes" if abs(off) < max(0.065, 2 * sd / published) else "no"]
        cells += ["yes" if abs(of.modulus.mean - published) < half else "no", f"{of.kappa.mean:.3f}"]
        cells += [f"{100 * of.half / of.kappa.mean:.1f}", f"{100 * of.change:.0f}", of.laws[0].law]
        cells += [f"{left[of.laws[0].law]:.0f}", f"{left['line']:.0f}"]
        expected = kappa_of(silicone, Cylinder(50, 30), Asked().range_n)[0]
        off_kappa.append(of.kappa.mean / expected - 1)
        cells += [f"{expected:.3f}", f"{100 * off_kappa[-1]:+.1f}"]
        yield f"| {name} | {' | '.join(cells)} |"
    yield f"\nκ off that of the kit, root mean square: {100 * np.sqrt(np.mean(np.square(off_kappa))):.1f} %."


def held_by_one(folders: list[Path]) -> Iterator[str]:
    """Each press alone, and the mean of the other four."""
    alone: dict[str, list[SpecimenPlates]] = {}
    for folder in folders:
        found = [read_plates([path], Asked()).specimen(folder.name) for path in sorted(folder.glob("*.csv"))]
        alone[folder.name] = [each for each in found if each]
    yield "| one press, interval of | holds the mean of the other four (%) | half width (%) |"
    yield "|---|---:|---:|"
    for level in LEVELS:
        held, width = [], []
        for own in alone.values():
            kappa = np.array([each.kappa.mean for each in own])
            for i, each in enumerate(own):
                held.append(abs(kappa[i] - np.delete(kappa, i).mean()) <= each.kappa.half(level))
                width.append(each.kappa.half(level) / kappa[i])
        yield f"| {level} | {100 * np.mean(held):.0f} | {100 * np.median(width):.1f} |"


def drawn(
    rng: np.random.Generator, counts: tuple[int, int, int], spread: Spread
) -> tuple[NestedMean, tuple[float, ...]]:
    """Presses, mountings and castings, and the truth at each level."""
    presses, mountings, castings = counts
    casting = KAPPA * (1 + spread.castings * rng.standard_normal(castings))
    mounting = casting[:, None] * (1 + spread.mountings * rng.standard_normal((castings, mountings)))
    press = mounting[..., None] * (1 + spread.presses * rng.standard_normal((castings, mountings, presses)))
    at = np.indices(press.shape).reshape(3, -1).astype(str)
    found = nested_mean(press.ravel(), np.full(press.size, 1e-3 * KAPPA), at[0].tolist(), at[1].tolist())
    return found, (float(mounting.mean()), float(casting.mean()), KAPPA)


def coverage(trials: int) -> Iterator[str]:
    yield "| presses, mountings, castings | true spread over stated | presses (%) | mountings (%) | castings (%) |"
    yield "|---|" + "---:|" * 4
    for counts in COUNTS:
        for times in TIMES:
            rng, stated = np.random.default_rng(1), Spread()
            true = Spread(*(times * getattr(stated, level) for level in LEVELS))
            held = []
            for _ in range(trials):
                found, truths = drawn(rng, counts, true)
                held.append([abs(found.mean - t) <= found.half(x) for x, t in zip(LEVELS, truths, strict=True)])
            cells = [f"{100 * share:.1f}" for share in np.mean(held, axis=0)]
            yield f"| {counts[0]}, {counts[1]}, {counts[2]} | {times:g} | {' | '.join(cells)} |"


def block_bootstrap(x: Floats, force: Floats, from_n: float, to_n: float, seed: int) -> float:
    """Standard error of the secant by moving blocks of what a polynomial of degree 5 leaves (Künsch 1989), share."""
    first, last = (int(np.argmax(force > each)) for each in (from_n, to_n))
    u, y = (x[first:last] - x[first]) / (x[last] - x[first]), force[first:last]
    rows = np.vander(u, 6)
    pinv = np.linalg.pinv(rows)
    fitted = rows @ (pinv @ y)
    left, n = y - fitted, y.size
    block = max(int(BLOCK * n), 2)
    starts = np.random.default_rng(seed).integers(0, n - block + 1, (DRAWS, -(-n // block)))
    again = left[(starts[..., None] + np.arange(block)).reshape(DRAWS, -1)[:, :n]]
    curves = (fitted + again - again.mean(axis=1, keepdims=True)) @ pinv.T @ rows.T
    spans = np.array([np.diff(np.interp([from_n, to_n], curve, u))[0] for curve in curves])
    return float(spans.std(ddof=1) / spans.mean())


def errors_within(plates: PlateTests) -> Iterator[str]:
    yield "| mixture | error within a press here (%) | by block bootstrap (%) | SD of presses (%) |"
    yield "|---|---:|---:|---:|"
    for name in (silicone.name for silicone in SILICONES):
        own = plates.of(name)
        here = [plates.ranges[i].secant_se / plates.ranges[i].secant for i in own]
        blocks = []
        for i in own:
            fit, trial = plates.ranges[i], plates.trials[i]
            x, force, _ = loading(trial.depth_mm, trial.force_n)
            blocks.append(block_bootstrap(x, force - fit.level_n, fit.from_n, fit.to_n, i))
        kappa = np.array([plates.ranges[i].secant for i in own])
        cells = [float(np.sqrt(np.mean(np.square(each)))) for each in (here, blocks)] + [
            kappa.std(ddof=1) / kappa.mean()
        ]
        yield f"| {name} | {' | '.join(f'{100 * each:.2f}' for each in cells)} |"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("phantoms", type=Path)
    parser.add_argument("--trials", type=int, default=4000)
    given = parser.parse_args()
    folders = [given.phantoms / silicone.name for silicone in SILICONES]
    files = [path for folder in folders for path in sorted(folder.glob("*.csv"))]
    fit_range(np.arange(40.0), np.arange(40.0), (0.5, 7.0))  # imports
    started = time.process_time()
    plates = read_plates(files, Asked())
    took = time.process_time() - started
    print("# Softness of real silicone\n")
    print(
        f"{len(files)} compressions of ten mixtures, one casting each, in {took:.1f} s of one processor. The modulus is"
    )
    print(
        "a line over the first 5 % of strain with ends that slide; κ is over 0.5 to 7 N; both with the stated spreads"
    )
    print("of mountings (2 %) and castings (3.5 %).\n")
    print("\n".join(moduli(plates)))
    print("\nOne press alone:\n")
    print("\n".join(held_by_one(folders)))
    print("\nErrors within a press, and how five presses scatter:\n")
    print("\n".join(errors_within(plates)))
    print(f"\nCoverage of 95 % intervals of kappa, {given.trials} made specimens each:\n")
    print("\n".join(coverage(given.trials)))


if __name__ == "__main__":
    main()
