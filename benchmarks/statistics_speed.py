"""What tables of many groups and samples of millions cost, beside SciPy in the same run.

``python -m benchmarks.statistics_speed > benchmarks/results/statistics_speed.md``: some minutes. Processor time, best
of interleaved repeats: ratios hold on a busy machine, seconds less so.
"""

from __future__ import annotations

import contextlib
import io
import tempfile
import time
from collections.abc import Callable
from itertools import combinations
from pathlib import Path

import numpy as np
from scipy import stats

from emg2vsa.arrays import Floats
from emg2vsa.cli import main as command
from emg2vsa.statistics.mann_whitney import mann_whitney

GROUPS, VALUES = 200, 10
LARGE = (300_000, 3_000_000)


def seconds(tasks: list[Callable[[], object]], repeats: int) -> list[float]:
    """Best processor time (s) of each task, all tasks in turn ``repeats`` times."""
    best = [float("inf")] * len(tasks)
    for _ in range(repeats):
        for i, task in enumerate(tasks):
            start = time.process_time()
            task()
            best[i] = min(best[i], time.process_time() - start)
    return best


def all_pairs_by_scipy(groups: Floats) -> None:
    """The tests of the pairs that SciPy has: Student, Welch and Mann-Whitney, pair by pair, and Tukey's p at 100 q."""
    for i, j in combinations(range(len(groups)), 2):
        stats.ttest_ind(groups[i], groups[j])
        stats.ttest_ind(groups[i], groups[j], equal_var=False)
        stats.mannwhitneyu(groups[i], groups[j])
    stats.studentized_range.sf(np.linspace(0.5, 8, 100), len(groups), groups.size - len(groups))


def main() -> None:
    rng = np.random.default_rng(0)
    groups = rng.standard_normal((GROUPS, VALUES))
    print("# Cost of many groups and of millions of values\n")
    print("`python -m benchmarks.statistics_speed`: processor time, best of interleaved repeats, the same run.\n")
    print("| task | emg2vsa, s | SciPy, s | ratio |\n|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        table = Path(folder) / "groups.csv"
        rows = [f"g{i},{value!r}" for i, group in enumerate(groups.tolist()) for value in group]
        table.write_text("group,value\n" + "\n".join(rows) + "\n")

        def whole() -> None:
            with contextlib.redirect_stdout(io.StringIO()):
                command(["stats", str(table), "--value", "value", "--group", "group"])

        ours, theirs = seconds([whole, lambda: all_pairs_by_scipy(groups)], 2)
    name = f"`emg2vsa stats`, {GROUPS} groups of {VALUES}, all {GROUPS * (GROUPS - 1) // 2} pairs"
    peer = "SciPy: t, Welch and Mann-Whitney of each pair, 100 of Tukey's p"
    print(f"| {name} ({peer}) | {ours:.1f} | {theirs:.1f} | {ours / theirs:.2f} |", flush=True)
    for n in LARGE:
        x, y = rng.standard_normal((2, n))
        pair = np.stack([x, y])
        ours, theirs = seconds([lambda p=pair: mann_whitney(p), lambda x=x, y=y: stats.mannwhitneyu(x, y)], 3)
        what = "p, rank-biserial, shift and its interval; SciPy: p"
        print(
            f"| Mann-Whitney of 2 × {n:.0e} values ({what}) | {ours:.2f} | {theirs:.2f} | {ours / theirs:.2f} |",
            flush=True,
        )


if __name__ == "__main__":
    main()
