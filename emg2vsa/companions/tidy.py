"""A tidy table, one row an observation, without a study: all rows together, and block by block.

Statistics of other installed packages, entry points of ``emg2vsa.statistics``, follow the tests here.
``statistic(values, groups, blocks)`` gets (n,) float64, (n,) texts, and (n,) texts or None where there are no blocks.
It returns an `Outcome`, or several. One that fails, or returns anything else, is an outcome without numbers whose note
says so: it takes nothing from the other results.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from decimal import Decimal, InvalidOperation

import numpy as np

from casr.errors import PluginError, said_by
from casr.plugins import Plugin, plugins
from emg2vsa.arrays import Floats, Ints
from emg2vsa.companions.groups import EqualityTests, equality_tests
from emg2vsa.companions.table import TableTests, table_tests
from emg2vsa.errors import DataError
from emg2vsa.statistics.clusters import Names, clusters_of
from emg2vsa.statistics.equivalence import Equivalence, tost
from emg2vsa.statistics.moments import shifted_doubles
from emg2vsa.statistics.outcome import Outcome

BROKEN = "no result: "
"""Begins the note on a statistic that failed."""


@dataclass(frozen=True)
class TidyTests:
    """groups (S,), count, mean, sd (S,) of all their rows; blocks (P,), empty without.

    together : all rows as one block, as if independent. equality : of groups; tost : of every pair of them
    against the margin, None without one. by_block : None without blocks.
    of_plugins : outcomes of statistics of other packages, each with whose it is.
    n : rows that entered; without_number, without_name : rows left out, and why.
    """

    groups: Names
    blocks: Names
    count: Ints
    mean: Floats
    sd: Floats
    together: TableTests
    equality: EqualityTests
    tost: Equivalence | None
    by_block: TableTests | None
    n: int
    without_number: int
    without_name: int
    alpha: float
    of_plugins: tuple[tuple[str, Outcome], ...]

    def alike(self) -> tuple[str, ...]:
        """Names of groups and of blocks that differ in capitals or spaces only: "'S1', 's1'"."""
        return (*_alike(self.groups), *_alike(self.blocks))


def _alike(names: Names) -> list[str]:
    same: dict[str, list[str]] = {}
    for name in names.tolist():
        same.setdefault("".join(name.split()).casefold(), []).append(name)
    return [", ".join(map(repr, of)) for of in same.values() if len(of) > 1]


def tidy_tests(
    values: Sequence[Decimal | None],
    group: Sequence[str],
    block: Sequence[str] | None,
    alpha: float,
    margin: float | None = None,
    *,
    protected: bool = False,
) -> TidyTests:
    """Test n ``values`` (None: no number), each of a ``group`` and perhaps a ``block`` ("": row is left out).

    Differences of values are taken exactly before anything is rounded. DataError where fewer than two groups, or no
    more values than groups, are left, or where the name of a group or block is one number written in several ways.
    """
    groups, blocks = np.array(group, dtype=np.str_), np.array(block or [""] * len(group), dtype=np.str_)
    number = np.array([value is not None for value in values], dtype=np.bool_)
    named = (groups != "") & ((blocks != "") if block else True)
    admitted = number & named
    groups, blocks = groups[admitted], blocks[admitted]
    _check(groups)
    _check_spelling(groups, "group")
    _check_spelling(blocks, "block")
    exact = np.array([value for value, enters in zip(values, admitted, strict=True) if enters], dtype=object)
    shifted, origins = shifted_doubles(exact[None, None, :])
    doubles, origin, every = shifted.ravel(), float(origins[0]), np.ones(groups.size, dtype=np.bool_)
    one = clusters_of(np.full(groups.shape, "all rows"), groups, doubles, every)
    together = table_tests(one, alpha, protected=protected, origin=origin)
    by_block = None
    if block:
        cells = clusters_of(blocks, groups, doubles, every)
        by_block = table_tests(cells, alpha, margin, protected=protected, origin=origin)
    return TidyTests(
        groups=one.specimens,
        blocks=cells.participants if block else np.array([], dtype=np.str_),
        count=one.count[0],
        mean=together.between_groups.anova.mean[0] + origin,
        sd=together.between_groups.sd[0],
        together=together,
        equality=equality_tests(one.values, together.between_groups.anova, alpha, margin),
        tost=tost(one.values, margin, alpha=alpha) if margin else None,
        by_block=by_block,
        n=int(np.count_nonzero(admitted)),
        without_number=int(np.count_nonzero(~number)),
        without_name=int(np.count_nonzero(number & ~named)),
        alpha=alpha,
        of_plugins=_plugin_outcomes(doubles + origin, groups, blocks if block else None),
    )


def _check(groups: Names) -> None:
    distinct = np.unique(groups).tolist()
    if len(distinct) < 2:
        found = f"one, {distinct[0]!r}" if distinct else "no row with a number and a name"
        raise DataError(
            "comparison of groups", wanted="two groups or more", found=found,
            do="Choose a column that tells groups apart, or check that the values are numbers.",
        )  # fmt: skip
    if groups.size <= len(distinct):
        raise DataError(
            "comparison of groups", wanted="groups of several values",
            found=f"{groups.size} values in {len(distinct)} groups",
            do="Choose a column whose entries repeat.",
        )  # fmt: skip


def _check_spelling(names: Names, column: str) -> None:
    """1, 1.0 and 01 are hardly three groups."""
    written: dict[Decimal, list[str]] = {}
    for name in np.unique(names).tolist():
        with suppress(InvalidOperation):
            if (number := Decimal(name)).is_finite():
                written.setdefault(number, []).append(name)
    for same in written.values():
        if len(same) > 1:
            raise DataError(
                f"comparison of groups, names of {column}s", wanted="each number written in one way",
                found=", ".join(map(repr, same)),
                do=f"Write the number alike in all rows, or begin the names of different {column}s with a letter.",
            )  # fmt: skip


def _plugin_outcomes(values: Floats, groups: Names, blocks: Names | None) -> tuple[tuple[str, Outcome], ...]:
    """Every outcome of every statistic of another package, with the name of the statistic and its distribution."""
    found = []
    for plugin in plugins("emg2vsa.statistics"):
        try:
            outcomes = _outcomes(plugin, values.copy(), groups.copy(), None if blocks is None else blocks.copy())
        except PluginError as fault:
            outcomes = (Outcome(method=plugin.name, n=values.size, notes=(f"{BROKEN}{fault}",)),)
        found += [(f"by {plugin}", outcome) for outcome in outcomes]
    return tuple(found)


def _outcomes(plugin: Plugin, values: Floats, groups: Names, blocks: Names | None) -> tuple[Outcome, ...]:
    statistic = plugin.load()
    try:
        answer = statistic(values, groups, blocks)
        outcomes = tuple(answer) if isinstance(answer, Iterable) else (answer,)
    except Exception as error:  # of foreign code
        raise plugin.fault("a statistic of these values", said_by(error)) from error
    for outcome in outcomes:
        if not isinstance(outcome, Outcome):
            raise plugin.fault("an Outcome or several", repr(outcome)[:80])
    return outcomes
