"""Own code of the statistics beside what libraries offer: lines, digits, time at the size of a study, decision.

``python -m benchmarks.statistics.on_libraries > benchmarks/results/statistics_on_libraries.json`` (five minutes).
"""

from __future__ import annotations

import json
import resource
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import mpmath
import numpy as np
import statsmodels.api as sm
from mpmath import mp, mpf
from scipy import special, stats
from statsmodels.stats.libqsturng import psturng
from statsmodels.stats.multitest import multipletests
from statsmodels.stats.power import TTestPower, ftest_power_f2

from benchmarks.bench.case import Case, Size, Way
from benchmarks.statistics.design_cases import design_cases
from benchmarks.statistics.exact_laws import power_of_rm, range_survival
from benchmarks.statistics.group_cases import group_cases, mixed_cases
from benchmarks.statistics.sample_cases import sample_cases
from benchmarks.stress.exact_curves import exact_huber, mpfs
from emg2vsa.curves.line import TUNING, fit_line_huber
from emg2vsa.statistics import studentized_range
from emg2vsa.statistics.effect_size import share_interval
from emg2vsa.statistics.multiplicity import adjust
from emg2vsa.statistics.power import least_for_power, power_paired, power_rm

PACKAGE = Path(__file__).resolve().parents[2] / "emg2vsa"
KEEP = "ours: "
ROWS: dict[str, tuple[str, str, str]] = {
    "one-way ANOVA of 5 x 10 with LSD pairs, 64": ("one_way, lsd", "statistics/anova.py", KEEP + "batch, pairs"),
    "ANOVA of 5 x 10 with Tukey": ("tukey", "statistics/post_hoc.py", KEEP + "time"),
    "Welch": ("welch, games_howell", "statistics/post_hoc.py", KEEP + "batch"),
    "Kruskal-Wallis of 3 x 10 with Dunn's pairs, 64": ("kruskal, dunn", "statistics/kruskal.py", KEEP + "batch"),
    "exact Mann-Whitney of 10 and 10, with ties": ("mann_whitney", "statistics/mann_whitney.py", KEEP + "ties"),
    "repeated-measures": ("rm_anova", "statistics/repeated.py", KEEP + "time, epsilons"),
    "Friedman": ("friedman", "statistics/repeated.py", KEEP + "import of scipy.stats"),
    "two one-sided": ("tost", "statistics/equivalence.py", KEEP + "batch"),
    "Kolmogorov": ("ks_normal", "statistics/normality.py", KEEP + "time, import of scipy.stats"),
    "Lilliefors": ("lilliefors", "statistics/lilliefors.py", KEEP + "digits"),
    "Shapiro": ("shapiro_wilk", "statistics/normality.py", KEEP + "digits, time"),
    "mixed model in volts, no variance": ("balanced_mixed", "statistics/mixed.py", KEEP + "digits"),
    "mixed model in volts, participants": ("balanced_mixed", "statistics/mixed.py", KEEP + "digits"),
    "adjusted p": ("adjust", "statistics/multiplicity.py", KEEP + "import, absent tests"),
    "interval of a share": ("share_interval", "statistics/effect_size.py", "SciPy: laws and root search"),
    "power of the paired": ("power_paired", "statistics/power.py", "statsmodels: TTestPower, a tail at a time"),
    "effect found": ("least_for_power", "statistics/power.py", "statsmodels: TTestPower; SciPy: brentq"),
    "power of repeated": ("power_rm", "statistics/power.py", "SciPy: ncfdtr"),
    "studentized": ("studentized_range", "statistics/studentized_range.py", KEEP + "small tails, time"),
    "Huber": ("fit_line_huber", "curves/line.py", KEEP + "batch"),
}
"""Beginning of a case's name: function, its file, what was decided."""
ROUNDS, SLOW_S = 3, 0.3
STAGE = """
import dataclasses, numpy as np
from emg2vsa.fits import Fits
from emg2vsa.hypotheses import test_hypotheses
from emg2vsa.settings import HypothesisSettings
shape = {people}, 5, 10
i, j, k = (each.ravel() for each in np.indices(shape))
rng, n = np.random.default_rng(0), i.size
b = (9e-6 - 1e-6 * j) * (1 + 0.15 * rng.standard_normal(n))
columns = {{field.name: np.zeros(n) for field in dataclasses.fields(Fits)}}
columns |= dict(
    participant=np.char.add("P", i.astype(str)), specimen=np.char.add("S", j.astype(str)), repetition=k + 1, b_v=b,
    verdict=np.full(n, "ok"), bin_force_n=np.full((n, 4), np.nan), bin_v=np.full((n, 4), np.nan), activity_unit="V",
    points="bins", weights="none", confidence=0.95,
)
test_hypotheses(Fits(**columns), HypothesisSettings())
"""


def new_cases() -> Iterator[Case]:
    """What the area of tests does not measure."""
    rng = np.random.default_rng(1)
    p = rng.uniform(size=(14, 10)) ** 3
    yield Case(
        "adjusted p by Holm, 14 families of 10", 1000, "families",
        (
            Way("emg2vsa", "adjust", lambda: adjust(p, "holm"), "equal"),
            Way("statsmodels", "multipletests, loop",
                lambda: np.array([multipletests(row, method="holm")[1] for row in p]), "equal"),
        ),
        lambda found: _worst(found, [_holm(row) for row in p]), "relative", "rational numbers",
    )  # fmt: skip
    f = np.geomspace(4, 40, 1000)
    yield Case(
        "interval of a share of variance, 1000 F", 1000, "intervals",
        (
            Way("emg2vsa", "share_interval", lambda: np.stack(share_interval(f, 4, 45, 50)), "equal"),
            Way("scipy", "special.ncfdtrinc", lambda: _by_inverse(f), "equal"),
        ),
        lambda found: _error_of_ends(f, found), "relative", "mpmath, 40 digits",
    )  # fmt: skip
    yield Case(
        "power of the paired t test, 14 people, d = 0.5", 1, "powers",
        (
            Way("emg2vsa", "power_paired", lambda: power_paired(0.5, 14), "equal"),
            Way("statsmodels", "TTestPower.power", lambda: TTestPower().power(0.5, 14, 0.05), "equal"),
        ),
        lambda found: _worst([found], [_exact_paired(0.5, 14, 0.05)]), "relative", "mpmath, 40 digits",
    )  # fmt: skip
    yield Case(
        "effect found with a power of 0.8, 14 people", 1, "effects",
        (
            Way("emg2vsa", "least_for_power", lambda: least_for_power(lambda x: power_paired(x, 14), 0.8), "equal"),
            Way("statsmodels", "TTestPower.solve_power",
                lambda: TTestPower().solve_power(None, 14, 0.05, 0.8), "equal"),
        ),
        lambda found: float(abs(_exact_paired(float(found), 14, 0.05) - mpf("0.8"))), "relative", "mpmath, 40 digits",
    )  # fmt: skip
    yield Case(
        "power of repeated measures, 14 people, 10 measurements", 1, "powers",
        (
            Way("emg2vsa", "power_rm", lambda: float(power_rm(14, 10)), "equal"),
            Way("statsmodels", "ftest_power_f2",
                lambda: ftest_power_f2(17.5 / (9 + 117 + 1), 9, 117, 0.05), "as used", "its own f2 of our lambda"),
        ),
        lambda found: _worst([found], [power_of_rm(14, 10, "0.25", "0.5", "0.05")]), "relative", "mpmath, 40 digits",
    )  # fmt: skip
    q = np.array([1.0, 3.5, 8.0, 16.0])
    known = [range_survival(mpf(x), 5, 45) for x in q.tolist()]
    yield Case(
        "studentized range, tails to 1e-14", 4, "tails",
        (
            Way("emg2vsa", "survival", lambda: studentized_range.survival(q, 5, 45), "equal"),
            Way("scipy", "studentized_range.sf", lambda: stats.studentized_range.sf(q, 5, 45), "equal"),
            Way("statsmodels", "psturng", lambda: psturng(q, 5, 45), "equal"),
        ),
        lambda found: _worst(found, known), "relative", "mpmath, 40 digits",
    )  # fmt: skip
    x = np.log(np.sort(rng.uniform(0.5, 7, (700, 22)), axis=1))
    y = 30 + 15 * x + rng.standard_t(2, x.shape)
    slopes = [exact_huber(mpfs(x[i]), mpfs(y[i]), mpf(TUNING))["b"] for i in range(3)]
    norm = sm.robust.norms.HuberT(TUNING)
    yield Case(
        "Huber's line of 22 points, 700 presses", 700, "fits",
        (
            Way("emg2vsa", "fit_line_huber", lambda: fit_line_huber(x, y, np.ones(x.shape)).slope, "equal"),
            Way("statsmodels", "RLM, loop", lambda: np.array(
                [sm.RLM(b, sm.add_constant(a), norm).fit(tol=1e-12, maxiter=200).params[1]
                 for a, b in zip(x, y, strict=True)]), "as used", "scale about the median, not about 0"),
        ),
        lambda found: _worst(found[:3], slopes), "relative", "mpmath, 40 digits",
    )  # fmt: skip


def _worst(found: Any, truth: Any) -> float:
    """Largest relative error of numbers, row by row."""
    pairs = zip(np.ravel(found).tolist(), [value for row in truth for value in np.ravel(row)], strict=True)
    return max(float(abs((mpf(ours) - true) / true)) if np.isfinite(ours) else 1.0 for ours, true in pairs)


def _holm(row: np.ndarray) -> list[mpf]:
    order, so_far = np.argsort(row), mpf(0)
    adjusted = [mpf(0)] * row.size
    for rank, i in enumerate(order.tolist()):
        so_far = max(so_far, min(mpf(float(row[i])) * (row.size - rank), mpf(1)))
        adjusted[i] = so_far
    return adjusted


def _ncf(f: mpf, nc: mpf) -> mpf:
    """P(F <= f), 4 and 45 degrees of freedom: the series of the noncentral law."""
    x, half = 4 * f / (4 * f + 45), nc / 2
    middle = int(half)
    reach = int(10 * mp.sqrt(half + 1)) + 30
    return mp.fsum(
        mp.exp(-half + j * mp.log(half) - mp.loggamma(j + 1)) * mp.betainc(2 + j, mpf(45) / 2, 0, x, regularized=True)
        for j in range(max(0, middle - reach), middle + reach)
    )


def _error_of_ends(f: np.ndarray, found: np.ndarray) -> float:
    """Largest relative error of the tails that the ends (2, n) leave, of three of the F."""
    errors = []
    for i in range(0, f.size, 400):
        for end, level in zip(found[:, i].tolist(), (mpf("0.975"), mpf("0.025")), strict=True):
            errors.append(abs(_ncf(mpf(f[i]), 50 * mpf(end) / (1 - mpf(end))) - level) / level)
    return float(max(errors))


def _by_inverse(f: np.ndarray) -> np.ndarray:
    nc = np.stack([special.ncfdtrinc(4, 45, level, f) for level in (0.975, 0.025)])
    return np.asarray(nc / (nc + 50))


def _exact_paired(effect: float, n: int, alpha: float) -> mpf:
    df, nc = n - 1, mpf(effect) * mp.sqrt(n)
    critical = mp.findroot(
        lambda t: mp.betainc(mpf(df) / 2, mpf(1) / 2, 0, df / (df + t * t), regularized=True) - mpf(alpha), mpf(2)
    )

    def above(shift: mpf) -> mpf:
        return mp.quad(
            lambda z: (
                mp.npdf(z)
                * (1 - mp.gammainc(mpf(df) / 2, df * ((z + shift) / critical) ** 2 / 2, mp.inf, regularized=True))
            ),
            [-shift, 0, 3, 6, 14] if shift > 0 else [-shift, -shift + 3, -shift + 6, 14],
        )

    return above(nc) + above(-nc)


def _measured(way: Way) -> tuple[Any, float]:
    output, best = None, np.inf
    for _ in range(ROUNDS):
        start = time.process_time()
        output = way.run()
        best = min(best, time.process_time() - start)
        if best > SLOW_S:
            break
    return output, best


def _digits(error: float | None, unit: str) -> str:
    if error is None:
        return ""
    return f"{min(16.0, -np.log10(max(error, 1e-16))):.1f}" if unit == "relative" else f"{error:.2g} {unit}"


def library_rows() -> Iterator[list[str]]:
    makers: tuple[Callable[[], Iterator[Case]], ...] = (
        new_cases, lambda: sample_cases(Size.FULL), lambda: mixed_cases(Size.FULL),
        lambda: design_cases(Size.FULL), lambda: group_cases(Size.FULL),
    )  # fmt: skip
    for make in makers:
        for case in make():
            label = next((label for label in ROWS if case.name.startswith(label)), None)
            if label is None:
                continue
            function, file, decision = ROWS[label]
            lines = len((PACKAGE / file).read_text().splitlines())
            for way in case.ways:
                output, seconds = _measured(way)
                digits = _digits(case.error_of(way, output), case.error_unit)
                first = [f"`{function}`", f"{lines} ({Path(file).name})"] if way.ours else ["", ""]
                last = decision if way.ours else way.note
                row = [*first, case.name, f"{way.library} {way.name}", digits, f"{1e3 * seconds:.3g}", last]
                print(json.dumps(row, ensure_ascii=False), file=sys.stderr, flush=True)
                yield row


def _cpu_s(program: str) -> float:
    """Smallest CPU time of a new process that runs ``program``."""
    found = []
    for _ in range(ROUNDS):
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run([sys.executable, "-c", program], check=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        found.append(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)
    return min(found)


def import_rows() -> Iterator[list[str]]:
    base = "import numpy, scipy.special, scipy.optimize"
    alone = _cpu_s(base)
    for module in ("scipy.stats", "pandas", "statsmodels.stats.power", "statsmodels.stats.multitest",
                   "statsmodels.stats.oneway", "statsmodels.stats.anova", "pingouin"):  # fmt: skip
        yield [f"`import {module}`", f"{_cpu_s(f'{base}, {module}') - alone:.2f}"]
    for people in (14, 1000):
        yield [
            f"stage of the hypotheses, {people} people, imports included",
            f"{_cpu_s(STAGE.format(people=people)):.2f}",
        ]


def main() -> None:
    mpmath.mp.dps = 50
    head = ["function", "own lines of its file", "case", "way", "digits", "CPU ms", "decision or note"]
    told = {
        "title": "Statistics on libraries",
        "blocks": [
            "`python -m benchmarks.statistics.on_libraries`: least CPU time of three runs on one core (of one, above "
            "0.3 s); digits of the worst number against exact arithmetic. What was decided: docs/decisions.",
            {"head": head, "rows": list(library_rows())},
            "What a library costs before its first call, beyond NumPy and the parts of SciPy that the stage has:",
            {"head": ["", "CPU s"], "rows": list(import_rows())},
        ],
    }
    print(json.dumps(told, indent=1, ensure_ascii=False))


if __name__ == "__main__":
    main()
