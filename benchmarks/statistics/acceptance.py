"""The numbers wanted (statistics notes 6), found and met, one line each."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from benchmarks.statistics.exact_laws import power_of_rm
from benchmarks.statistics.nist_samples import CEILING, FROM_TEXT, OURS
from benchmarks.statistics.nist_tables import NistTables
from benchmarks.statistics.task import Measured
from emg2vsa.statistics.power import power_rm

POWER = 0.819421399316
Line = tuple[str, str, str, bool]
"""What, wanted, found, met."""


def acceptance(tasks: Sequence[Measured], tables: NistTables) -> None:
    """Print the list."""
    print(f"\n{'acceptance (statistics notes 6)':66}{'wanted':>15}{'found':>16}  met")
    _show(*_nist(tables), *_digits(tasks), _power())
    print(
        "\ntimes slower than ours: half of what the notes (3e) found on another machine; compare ms with noted ms above"
    )
    for one in tasks:
        if lines := list(_speed(one)):
            print(one.task.title)
            _show(*lines)


def _show(*lines: Line) -> None:
    for what, wanted, found, met in lines:
        print(f"{what:66}{wanted:>15}{found:>16}  {'yes' if met else 'NO'}")


def _at_least(what: str, wanted: float, found: float) -> Line:
    return what, f">= {wanted}", f"{found:.1f}", bool(found >= wanted)


def _nist(tables: NistTables) -> Iterator[Line]:
    if tables.anova is not None:
        short = float(np.max(tables.anova.column(CEILING) - tables.anova.column(OURS)))
        yield "ANOVA, float64: digits below what doubles allow, worst NIST set", "<= 0.1", f"{short:.1f}", short <= 0.1
        found = float(np.min(tables.anova.column(FROM_TEXT)))
        yield _at_least("ANOVA, decimal text: digits, worst NIST set", 14.5, found)
    if tables.nonlinear is not None:
        for start in (1, 2):
            column = tables.nonlinear.column(f"emg2vsa {start}")
            good, n = int(np.count_nonzero(column >= 6.5)), column.size
            yield f"nonlinear NIST sets with 6.5 digits from start {start}", f"{n} of {n}", f"{good} of {n}", good == n
    for name, wanted in (("DanWood", 11.0), ("MGH10 with b3 given", 9.5)):
        if name in tables.exponential:
            yield _at_least(f"exponential fit: digits on {name}", wanted, tables.exponential[name])


WANTED_DIGITS = (
    ("logarithmic fits", "logarithmic fit", 14.5, None),
    ("bootstrap refits", "exponential fit", 13.0, ("p", "q")),
    ("Kolmogorov-Smirnov", "Kolmogorov-Smirnov", 13.0, None),
    ("LSD", "ANOVA and LSD", 13.0, None),
    ("Kruskal-Wallis", "Kruskal-Wallis and Dunn", 13.0, None),
    ("mixed model", "mixed model, boundary included", 12.0, None),
)
"""Part of the tasks' titles, what it is, digits wanted, of which numbers (None: all)."""


def _digits(tasks: Sequence[Measured]) -> Iterator[Line]:
    for title, what, wanted, names in WANTED_DIGITS:
        found = [
            digits
            for one in tasks
            if title in one.task.title
            for name, digits in one.digits[""].items()
            if names is None or name in names
        ]
        if found:
            yield _at_least(f"{what}: digits, worst number", wanted, min(found))


def _power() -> Line:
    found = float(power_rm(14, 10))
    error = abs(found - float(power_of_rm(14, 10, "0.25", "0.5", "0.05")))
    met = error <= 1e-12 and abs(found - POWER) <= 1e-12
    return "power of n = 14, m = 10 (error against the 40-digit series)", f"{POWER}", f"{found:.12f}", met


def _speed(one: Measured) -> Iterator[Line]:
    """Ratios of section 3e: each wanted one, halved, beside the one found."""
    for peer in one.task.peers:
        if peer.wanted is not None:
            yield f"  {peer.name}", f">= {peer.wanted:.0f}x", f"{one.ratio(peer):.0f}x", one.met(peer)
