"""Does the comparison of whole curves err as often as it says, how much does it find, and does spm1d find the same?

``python -m benchmarks.whole_curve [--write FILE]``: some twenty minutes. The comparison with spm1d (GPL, not a
dependency) is left out where spm1d is not installed.
"""

from __future__ import annotations

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")

import importlib.util
import itertools
import textwrap
import warnings
from collections.abc import Iterator
from importlib.metadata import version

import numpy as np
from scipy import stats

from benchmarks.bench.record import print_page
from emg2vsa.arrays import Floats
from emg2vsa.statistics.whole_curve import curve_tests

SPECIMENS, FORCES, PEOPLE = 5, 22, (5, 14)
"""As in the demo study, and a study too small for patterns of signs."""
NULLS, DRAWS, FOUND, BESIDE = 2000, 999, 400, 200
"""Studies without a difference, directions drawn in each; studies with one, and studies beside spm1d."""
ALPHA = 0.05
SPREAD = np.linspace(1, 4, SPECIMENS)[:, None] * np.linspace(0.5, 2, FORCES)
"""Unequal SD: of the last specimen four times that of the first, at the highest force four times that at the lowest."""
WORLDS = {
    "independent": "normal, independent from force to force",
    "memory": "normal, correlation .9 between neighbouring forces",
    "unequal": "the same, SD from 1 to 4 over specimens times 0.5 to 2 over forces",
    "t3": "the same, each person's curves times one factor, so that they follow Student's t with 3 df",
    "lognormal": "lognormal with equal means, SD of the logarithm from .2 to .8 over specimens",
    "alike": "lognormal, SD of the logarithm .5 on every specimen",
}
EFFECTS = {5: (1.0, 2.0, 3.0, 4.0), 14: (0.5, 0.75, 1.0, 1.5)}
"""Difference of one specimen from the others, over the SD of a person's difference between two specimens."""
WHERE = slice(8, 15)
"""The seven forces at which it differs."""


def factor(memory: float) -> Floats:
    """Cholesky factor of a first-order autoregression along force."""
    return np.linalg.cholesky(memory ** np.abs(np.subtract.outer(np.arange(FORCES), np.arange(FORCES))))


def null_study(world: str, people: int, seed: int) -> Floats:
    """Curves (P, S, G) whose population means are equal."""
    rng = np.random.default_rng((seed, people, list(WORLDS).index(world)))
    y = rng.standard_normal((people, SPECIMENS, FORCES))
    if world == "independent":
        return np.asarray(y)
    y = y @ factor(0.9).T
    if world in ("lognormal", "alike"):
        sd = np.linspace(0.2, 0.8, SPECIMENS)[:, None] if world == "lognormal" else 0.5
        return np.asarray(np.exp(sd * y) - np.exp(sd**2 / 2))
    if world != "memory":
        y *= SPREAD
    if world == "t3":
        y *= np.sqrt(3 / rng.chisquare(3, (people, 1, 1)))
    return np.asarray(y)


def signs_p(y: Floats, seed: int) -> float:
    """Smallest p of F over the forces by random signs of people, all patterns where they are few."""
    n = len(y)
    own = y - y.mean(axis=1, keepdims=True)
    if n < 10:
        w = np.array(list(itertools.product((1.0, -1.0), repeat=n)))
    else:
        w = np.random.default_rng(seed).choice((1.0, -1.0), (DRAWS + 1, n))
        w[0] = 1
    z = (w @ own.reshape(n, -1)).reshape(-1, *y.shape[1:])
    largest = np.max(np.sum(z**2, axis=1) / np.sum(own**2, axis=(0, 1)), axis=1)
    return float(np.mean(largest >= largest[0] * (1 - 1e-12)))


def errors(world: str, people: int) -> list[float]:
    """Percent of studies in which something differs: by F, by pairs, by signs; and whose bands hold every truth.

    For the bands the specimens differ by hundreds of SDs.
    """
    shift = 1e3 * np.arange(SPECIMENS)[:, None]
    counted = np.zeros(4)
    for seed in range(NULLS):
        y = null_study(world, people, seed)
        found = curve_tests(y, ALPHA, DRAWS, seed)
        apart = curve_tests(y + shift, ALPHA, DRAWS, seed)
        true = (shift[apart.first] - shift[apart.second])[:, 0, None]
        held = np.all(np.abs(apart.pair_difference - true) <= apart.pair_half_width)
        counted += (
            np.any(found.p <= ALPHA), np.any(found.pair_p <= ALPHA), signs_p(y, seed) <= ALPHA, held,
        )  # fmt: skip
    return (100 * counted / NULLS).tolist()


def powers(people: int, effect: float) -> list[float]:
    """Percent of studies that find the difference by F, by F with Bonferroni's correction over forces, by signs, and by
    a right pair; of right forces and pairs that are found; of studies with a wrong pair or force."""
    counted = np.zeros(6)
    right = np.zeros((SPECIMENS * (SPECIMENS - 1) // 2, FORCES), dtype=np.bool_)
    right[: SPECIMENS - 1, WHERE] = True
    for seed in range(FOUND):
        y = null_study("memory", people, 10**6 + seed)
        y[:, 0, WHERE] += effect * np.sqrt(2)
        found = curve_tests(y, ALPHA, DRAWS, seed)
        pair = found.pair_p <= ALPHA
        alone = stats.f.sf(found.f, SPECIMENS - 1, (SPECIMENS - 1) * (people - 1))
        counted += (
            np.any(found.p <= ALPHA), np.any(alone <= ALPHA / FORCES), signs_p(y, seed) <= ALPHA, np.any(pair & right),
            np.mean(pair[right]), np.any(pair & ~right),
        )  # fmt: skip
    return (100 * counted / FOUND).tolist()


Ranges = list[tuple[int, int]]
"""First and last force of each cluster."""


def by_spm1d(y: Floats) -> tuple[float, Ranges]:
    """Threshold and clusters of the paired t of two specimens, else of the repeated-measures F."""
    import spm1d

    people, specimens, forces = y.shape
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # one curve a person and specimen: "residuals are approximate"
        if specimens == 2:
            found = spm1d.stats.ttest_paired(y[:, 0], y[:, 1]).inference(ALPHA, two_tailed=True)
        else:
            who, what = np.repeat(np.arange(people), specimens), np.tile(np.arange(specimens), people)
            found = spm1d.stats.anova1rm(y.reshape(-1, forces), what, who, equal_var=True).inference(ALPHA)
    ends = [each.endpoints for each in found.clusters]
    return float(found.zstar), sorted((int(np.ceil(low)), int(np.floor(high))) for low, high in ends)


def by_us(y: Floats, seed: int, draws: int) -> tuple[float, Ranges]:
    """The same of ours."""
    found, pair = curve_tests(y, ALPHA, draws, seed), 0 if y.shape[1] == 2 else -1
    threshold = found.f_threshold if pair < 0 else found.t_threshold
    return threshold.value, [(each.start, each.stop - 1) for each in found.clusters() if each.pair == pair]


def smooth_study(people: int, specimens: int, effect: float, seed: int) -> Floats:
    """Normal curves whose correlation falls as a Gaussian of SD 3 forces; from a random force on, seven differ."""
    rng = np.random.default_rng((seed, people, specimens))
    away = np.subtract.outer(np.arange(FORCES), np.arange(FORCES)) / 3
    root = np.linalg.cholesky(np.exp(-(away**2) / 2) + 1e-9 * np.eye(FORCES))
    y = rng.standard_normal((people, specimens, FORCES)) @ root.T
    start = int(rng.integers(2, 13))
    y[:, 0, start : start + 7] += effect * np.sqrt(2)
    return np.asarray(y)


def beside(people: int, specimens: int) -> list[float]:
    """Mean thresholds of both; percent of nulls in which each finds something, then of studies with a difference in
    which both find the same clusters, ends within one force; largest distance of ends where they find as many."""
    thresholds, false, same, far = [], np.zeros(2), 0, 0
    for seed in range(BESIDE):
        both = by_us(y := smooth_study(people, specimens, 0, seed), seed, DRAWS), by_spm1d(y)
        false += [bool(ranges) for _, ranges in both]
        ours, theirs = by_us(y := smooth_study(people, specimens, 2.0, seed), seed, 9_999), by_spm1d(y)
        thresholds.append((ours[0], theirs[0]))
        if len(ours[1]) == len(theirs[1]):
            apart = int(np.abs(np.array(ours[1]) - np.array(theirs[1])).max(initial=0))
            same, far = same + (apart <= 1), max(far, apart)
    return [*np.mean(thresholds, axis=0), *(100 * false / BESIDE), 100 * same / BESIDE, far]


def _filled(text: str) -> str:
    """A paragraph of Markdown."""
    return f"{textwrap.fill(text, 110)}\n"


def rows(cells: Iterator[list[object]], *heads: str) -> Iterator[str]:
    """A table of Markdown, line by line."""
    yield "| " + " | ".join(heads) + " |"
    yield "|---" + "|---:" * (len(heads) - 1) + "|"
    for row in cells:
        yield "| " + " | ".join(each if isinstance(each, str) else f"{each:.3g}" for each in row) + " |"
    yield ""


def page() -> Iterator[str]:
    """Title, what was asked, and a table for each question."""
    half = 196 * np.sqrt(ALPHA * (1 - ALPHA) / NULLS)
    yield "# Whole curves: errors, power, and spm1d\n"
    yield _filled(
        f"`python -m benchmarks.whole_curve`: curves of {SPECIMENS} specimens at {FORCES} forces, compared "
        f"at all forces with an error of {100 * ALPHA:g} % (decision 44). {NULLS} studies without a "
        f"difference: percent in which F, or any pair, passes its threshold anywhere (± {half:.1f} at 5). "
        "Signs: the same F by random signs of people in place of rotations; 5 people have 16 patterns, so p "
        "is .0625 at least. Bands: percent of studies whose bands of all pairs hold all true differences, "
        "where specimens are 1000 SDs apart."
    )
    yield from rows(
        ([what, str(n), *errors(world, n)] for world, what in WORLDS.items() for n in PEOPLE),
        "world", "people", "F", "pairs", "F by signs", "bands hold",
    )  # fmt: skip
    yield _filled(
        f"Power, {FOUND} studies each: one specimen differs from the other four at seven "
        f"of {FORCES} forces, by so many SDs of a person's difference between two specimens; "
        "correlation .9 between neighbouring forces. Percent of studies that find it, percent of the right "
        "forces and pairs that are found, and percent of studies with any wrong one."
    )
    yield from rows(
        ([f"{effect:g}", str(n), *powers(n, effect)] for n in PEOPLE for effect in EFFECTS[n]),
        "difference (SD)", "people", "F", "F, Bonferroni over forces", "F by signs", "a right pair",
        "right forces and pairs", "a wrong force or pair",
    )  # fmt: skip
    if importlib.util.find_spec("spm1d") is None:
        yield "spm1d is not installed here, so it was not compared.\n"
        return
    yield _filled(
        f"Beside spm1d {version('spm1d')} (random field theory), {BESIDE} studies each: smooth normal "
        "curves, where both apply. Mean threshold of each; percent of studies without a difference in which "
        "each finds one; percent of studies with a difference of 2 SD at seven forces in which both find "
        "the same ranges, ends within one force; and the largest distance of their ends, in forces, where "
        "they find equally many."
    )
    tests = {2: "paired t of 2 specimens", 3: "repeated-measures F of 3 specimens"}
    yield from rows(
        ([what, str(n), *beside(n, k)] for k, what in tests.items() for n in PEOPLE),
        "test", "people", "threshold, rotations", "threshold, spm1d", "false, rotations", "false, spm1d", "same ranges",
        "largest distance of ends",
    )  # fmt: skip


if __name__ == "__main__":
    print_page(__doc__, page)
