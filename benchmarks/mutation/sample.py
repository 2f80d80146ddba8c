"""A seeded sample of mutants over all packages, each package in proportion to its lines."""

from __future__ import annotations

import random
from bisect import bisect_right
from collections import Counter
from dataclasses import dataclass
from itertools import accumulate
from pathlib import Path

from benchmarks.mutation.mutants import Mutant, mutants_of

PACKAGES = ("emg2vsa", "casr")


@dataclass(frozen=True)
class Chosen:
    """One mutant of the sample. module : path of its file in the tree."""

    module: str
    mutant: Mutant


def package_of(module: Path) -> str:
    """``emg2vsa.statistics`` of emg2vsa/statistics/anova.py; ``emg2vsa`` of the modules that stand alone."""
    return ".".join(module.parts[:2]) if len(module.parts) > 2 else module.parts[0]


def sample(tree: Path, *, seed: int, count: int, package: str = "") -> list[Chosen]:
    """``count`` mutants of the packages whose name begins with ``package``.

    Packages are drawn by systematic sampling of their lines, one after the other: so a package has its share to within
    one mutant, and a small one its chance. Within a package a kind of change is drawn first, then one of its mutants:
    else constants would crowd out the rest. Raises ValueError for an unknown package.
    """
    modules = [path.relative_to(tree) for each in PACKAGES for path in sorted((tree / each).rglob("*.py"))]
    modules = [module for module in modules if package_of(module).startswith(package)]
    if not modules:
        raise ValueError(f"--package: expected a package of emg2vsa or casr, but found {package!r}. Name one of them.")
    rng = random.Random(seed)
    lines = [len(_text(tree / module).splitlines()) for module in modules]
    ends, every = list(accumulate(lines)), sum(lines) / count
    start = rng.uniform(0, every)
    names = Counter(package_of(modules[bisect_right(ends, start + k * every)]) for k in range(count))
    chosen = []
    for name, wanted in names.items():
        kinds: dict[str, list[Chosen]] = {}
        for module in modules:
            if package_of(module) == name:
                for mutant in mutants_of(_text(tree / module)):
                    kinds.setdefault(mutant.kind, []).append(Chosen(module.as_posix(), mutant))
        for _ in range(min(wanted, sum(map(len, kinds.values())))):
            of_kind = kinds[rng.choice(sorted(kind for kind, left in kinds.items() if left))]
            chosen.append(of_kind.pop(rng.randrange(len(of_kind))))
    rng.shuffle(chosen)  # so that a run that was ended early is a sample too
    return chosen


def _text(path: Path) -> str:
    return path.read_text(encoding="utf-8")
