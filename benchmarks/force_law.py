"""Is a wrong law of force told, and a true one left alone? Studies of raw EMG and force whose curve is known.

``python -m benchmarks.force_law [--studies 40] [--write FILE]``: two processes, some ten minutes. Six people of eight
presses each on one specimen, everybody with a level of their own (lognormal, SD .2); EMG and force pass through the
default analysis, and presses that enter the tests count.

Before: one of the other laws predicts left-out bins better than the logarithm with p < .05 (``companions.force_laws``),
which is all that was said. Now: the interval of the distance from a law lies above what matters.
"""

from __future__ import annotations

import argparse
import time
from collections import Counter
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import NamedTuple

import numpy as np

from benchmarks.bench.record import keep
from benchmarks.laboratory import Laboratory, simulate_session
from emg2vsa.arrays import Floats
from emg2vsa.companions.force_laws import LAWS, LEFT_OUT, force_laws
from emg2vsa.companions.law_misfit import MATTERS, cell_misfits, compare_misfits
from emg2vsa.extraction.extract import extract_trials
from emg2vsa.fits import Fits, concatenate, fit_trials
from emg2vsa.recordings import Channel
from emg2vsa.settings import (
    CocontractionSettings,
    FilterSettings,
    FitSettings,
    ForceChannelSettings,
    WindowSettings,
)

PEOPLE, PRESSES, LEVEL_SD = 6, 8, 0.2
USE, WINDOW = "ok", WindowSettings()
TRUTHS: dict[str, Callable[[Floats], Floats]] = {
    "logarithm, 30 + 15 ln F": lambda f: 30 + 15 * np.log(f),
    "power, 4 + 9 F^.7": lambda f: 4 + 9 * f**0.7,
    "power, 25 F^.4": lambda f: 25 * f**0.4,
    "straight line, 5 + 8 F": lambda f: 5 + 8 * f,
    "quadratic, 10 + 1.2 F^2": lambda f: 10 + 1.2 * f**2,
    "sigmoid, 8 + 50 / (1 + exp(-1.6 (F - 3.5)))": lambda f: 8 + 50 / (1 + np.exp(-1.6 * (f - 3.5))),
    "saturating, 60 (1 - exp(-F / 1.2))": lambda f: 60 * -np.expm1(-f / 1.2),
    "flat, 35": lambda f: np.full(np.shape(f), 35.0),
}


class Said(NamedTuple):
    """Of one study. before : another law predicts better. told : by law. person : share of people told of the
    logarithm. share, low, high : distance from the logarithm. used : presses. cpu_ms : of all that is new."""

    before: bool
    told: tuple[bool, ...]
    person: float
    share: float
    low: float
    high: float
    nearest: str
    used: int
    cpu_ms: float


def recording(truth: str, person: str, seed: tuple[int, int]) -> Fits:
    """Fits of one person's presses."""
    level = float(np.exp(LEVEL_SD * np.random.default_rng([*seed, 35]).standard_normal()))
    curve = TRUTHS[truth]
    laboratory = Laboratory(presses=PRESSES, law=lambda f: 1e-6 * level * curve(f))
    session = simulate_session(laboratory, 1000 * seed[0] + seed[1])
    emg = {
        str(i): Channel(str(i), samples, "V", laboratory.fs_hz, 0.0, "simulated")
        for i, samples in enumerate(session.emg_v)
    }
    force = Channel("Fz", session.force_n, "N", laboratory.force_fs_hz, 0.0, "simulated")
    trials = extract_trials(
        emg, force, participant=person, specimen="S1", filters=FilterSettings(),
        cocontraction=CocontractionSettings(), window=WINDOW, force_channel=ForceChannelSettings(name="Fz"),
    )  # fmt: skip
    return fit_trials(trials, FitSettings(), WINDOW)


def study(truth: str, seed: int) -> Said:
    fits = concatenate(recording(truth, f"P{i + 1}", (seed, i)) for i in range(PEOPLE))
    laws = force_laws(fits, USE)
    by_bin = LEFT_OUT.index("bin")
    began = time.process_time()
    found = compare_misfits(cell_misfits(fits, USE))
    cpu_ms = 1e3 * (time.process_time() - began)
    of_log = found.together[0]
    return Said(
        before=bool(np.any((laws.ratio[by_bin, 1:] < 1) & (laws.p[by_bin, 1:] < 0.05))),
        told=tuple(misfit.told for misfit in found.together),
        person=float(np.mean([found.of(0, i).told for i in range(found.participant.size)])),
        share=of_log.share,
        low=of_log.low,
        high=of_log.high,
        nearest=found.nearest(),
        used=int(found.presses.sum()),
        cpu_ms=cpu_ms,
    )


def page(studies: int) -> Iterator[str]:
    with ProcessPoolExecutor(2) as pool:
        every = [(truth, seed) for truth in TRUTHS for seed in range(studies)]
        found = list(pool.map(study, *zip(*every, strict=True), chunksize=4))
    of = {truth: found[i * studies : (i + 1) * studies] for i, truth in enumerate(TRUTHS)}
    yield "# A wrong law of force is told\n"
    yield f"{studies} studies a row, of {PEOPLE} people with {PRESSES} presses of one specimen; the same seeds in all."
    yield "Before: another law predicts left-out force bins better than the logarithm, p < .05. Now: the 95 % interval"
    yield f"of the distance from a law lies above {100 * MATTERS:g} % of the level.\n"
    yield (
        "| truth, uV | before: said, % | logarithm is wrong, % | power is wrong, % | straight line is wrong, % | "
        "none of the three, % | person: logarithm is wrong, % | distance from logarithm, % of level | nearest law |"
    )
    yield "| --- |" + " ---: |" * 7 + " --- |"
    for truth, row in of.items():
        told = 100 * np.mean([each.told for each in row], axis=0)
        distance = np.array([[each.share, each.low, each.high] for each in row])
        share, low, high = 100 * np.mean(distance, axis=0)
        nearest = ", ".join(f"{name} {n}" for name, n in Counter(each.nearest for each in row).most_common())
        cells = (
            truth, f"{100 * np.mean([each.before for each in row]):.1f}",
            *(f"{told[LAWS.index(law)]:.1f}" for law in ("logarithm", "power", "linear")),
            f"{100 * np.mean([all(each.told) for each in row]):.1f}",
            f"{100 * np.mean([each.person for each in row]):.1f}", f"{share:.1f} [{low:.1f}, {high:.1f}]", nearest,
        )  # fmt: skip
        yield f"| {' | '.join(cells)} |"
    cpu_ms = np.median([each.cpu_ms for each in found]) / PEOPLE
    used = np.mean([each.used for each in found]) / (PEOPLE * PRESSES)
    yield f"\nProcessor time of what is new: {cpu_ms:.1f} ms a recording. {100 * used:.1f} % of the presses counted."


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--studies", type=int, default=40)
    parser.add_argument("--write", type=Path, metavar="FILE", help="a record of it there")
    arguments = parser.parse_args()
    text = "\n".join(page(arguments.studies))
    print(text)
    if arguments.write:
        keep(arguments.write, text)


if __name__ == "__main__":
    main()
