"""Do the intervals of a person's b hold where the level of the muscle wanders, and those of shrunken values?

``python -m benchmarks.hierarchy_coverage [SESSIONS]``, kept by ``benchmarks.bench.record``: a minute.
"""

from __future__ import annotations

import sys
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace

import numpy as np

from benchmarks.emg_bias_coverage import CLEAN, fitted
from emg2vsa.arrays import Floats, mean_of
from emg2vsa.fits import usable
from emg2vsa.statistics.hierarchy import recording_means, shrunken
from emg2vsa.statistics.outcome import Outcome
from emg2vsa.statistics.reml import fit_reml

PRESSES, DRAWS = 10, 1000
WANDERS_S = (0.0, 0.2, 0.5, 2.0, 10.0)
"Time constants of a level that wanders by 20 %; 0: it does not."
DESIGNS = ((30, 2), (30, 3), (30, 5), (30, 10), (5, 5), (5, 10), (1, 5), (1, 10))
"Recordings of a study, and presses of each."
WORLDS = {
    "people differ by 30 %, their specimens by 5 %": (0.30, 0.05, 0.10, 0.0),
    "people differ by 30 %, presses of some people scatter 3 times as much": (0.30, 0.05, 0.05, 0.6),
    "people are equal, their specimens differ by 10 %": (0.0, 0.10, 0.10, 0.0),
    "nobody differs": (0.0, 0.0, 0.10, 0.0),
}
"SD of people, of people by specimens, of presses, and of the logarithm of people's own scatter."


def session(wanders_s: float, seed: int) -> Floats:
    """(4, PRESSES), over the true b: b, level, error of corrections, half width; NaN of a press that is not ok."""
    laboratory = replace(CLEAN, level_sd=0.2, level_s=wanders_s) if wanders_s else CLEAN
    _, fits = fitted(laboratory, "after", seed)
    found = np.full((4, PRESSES), np.nan)
    ok = usable(fits, "ok") & (fits.repetition <= PRESSES)
    half = (fits.b_hi_v - fits.b_lo_v) / 2
    level = (fits.v_min_v + fits.v_max_v) / 2
    columns = np.stack([fits.b_v, level, fits.b_bias_se * np.abs(fits.b_v), half]) / laboratory.b_v
    found[:, fits.repetition[ok] - 1] = columns[:, ok]
    return found


def of_means(sessions: Floats, recordings: int, presses: int) -> tuple[float, float, float, float]:
    """Coverage of the mean b of a recording and of b of a press, percent; median half width of both, percent of b."""
    rng, hits, halves = np.random.default_rng(1), [], []
    for _ in range(DRAWS):
        first = int(rng.integers(PRESSES - presses + 1))
        drawn = sessions[rng.choice(len(sessions), recordings, replace=False), :, first : first + presses]
        b, level, error, _ = np.moveaxis(drawn, 1, 0)
        order = np.argsort(~np.isfinite(b), axis=1, kind="stable")
        found = recording_means(np.take_along_axis(b, order, axis=1), mean_of(level), mean_of(error))
        known = np.isfinite(found.half)
        hits += (np.abs(found.mean - 1) <= found.half)[known].tolist()
        halves += found.half[known].tolist()
    b, half = sessions[:, 0], sessions[:, 3]
    of_press = np.abs(b - 1)[np.isfinite(b)] <= half[np.isfinite(b)]
    return (
        100 * float(np.mean(hits)),
        100 * float(of_press.mean()),
        100 * float(np.median(halves)),
        100 * float(np.nanmedian(half)),
    )


def of_model(world: tuple[float, float, float, float], people: int, presses: int) -> tuple[float, float, float, float]:
    """Coverage of a person over the specimens and on one, percent; error of shrunken values over that of means."""
    rng, hits, ratio, absent = np.random.default_rng(2), [], [], []
    specimens = np.array([2.0, 1.7, 1.3, 1.2, 0.7])
    of_people, of_cells, of_presses, apart = world
    for _ in range(DRAWS // 4):
        truth = specimens + of_people * rng.standard_normal((people, 1)) + of_cells * rng.standard_normal((people, 5))
        own = of_presses * np.exp(apart * rng.standard_normal((people, 1, 1)))
        values = truth[..., None] + own * rng.standard_normal((people, 5, presses))
        values[0, -1] = np.nan  # a recording that is missing
        if isinstance(fit := fit_reml(values), Outcome):
            continue
        found = shrunken(fit)
        inside = (found.cell_low <= truth) & (truth <= found.cell_high)
        over = truth.mean(axis=1)
        hits.append(
            [
                np.mean((found.person_low <= over) & (over <= found.person_high)),
                inside.ravel()[np.arange(inside.size) != 4].mean(),
            ]
        )
        absent.append(inside[0, -1])
        ratio.append([np.nanmean((found.cell - truth)[1:] ** 2), np.nanmean((mean_of(values) - truth)[1:] ** 2)])
    shrunk, plain = np.mean(ratio, axis=0)
    person, cell = 100 * np.mean(hits, axis=0)
    return float(person), float(cell), 100 * float(np.mean(absent)), float(np.sqrt(shrunk / plain))


def main() -> None:
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 200
    print("# b of a person is not b of a press\n")
    print("`python -m benchmarks.hierarchy_coverage`: sessions of 10 presses, one every 5.5 s, whose level wanders by")
    print(f"20 %; {count} sessions a time constant, of which {DRAWS} studies are drawn; presses that are ok, 95 %.\n")
    print("| level wanders over | recordings, presses | person's b: coverage, half width % | b of a press |")
    print("|---|---|---|---|")
    with ProcessPoolExecutor(2) as pool:
        for wanders_s in WANDERS_S:
            found = np.array(list(pool.map(session, [wanders_s] * count, range(count), chunksize=5)))
            for recordings, presses in DESIGNS:
                mean, press, half, of_press = of_means(found, recordings, presses)
                name = f"{wanders_s:g} s" if wanders_s else "not at all"
                print(f"| {name} | {recordings}, {presses} | {mean:.1f}, {half:.1f} | {press:.1f}, {of_press:.1f} |")
    print("\n## Shrunken values\n")
    print("Five specimens, one recording missing; values of the mixed model, 95 % intervals.\n")
    print("| world | people, presses | person, on a specimen, on the missing one % | error over that of means |")
    print("|---|---|---|---|")
    for name, world in WORLDS.items():
        for people, presses in ((6, 4), (14, 10)):
            person, cell, absent, ratio = of_model(world, people, presses)
            print(f"| {name} | {people}, {presses} | {person:.1f}, {cell:.1f}, {absent:.1f} | {ratio:.2f} |")


if __name__ == "__main__":
    main()
