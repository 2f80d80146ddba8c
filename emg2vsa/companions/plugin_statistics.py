"""Statistics of other installed packages: entry points of ``emg2vsa.statistics``, shown after the tests here.

``statistic(values, groups, blocks)`` gets (n,) float64, (n,) texts, and (n,) texts or None where there are no blocks.
It returns an `Outcome`, or several. One that fails, or returns anything else, is an outcome without numbers whose note
says so: it takes nothing from the other results.
"""

from __future__ import annotations

from collections.abc import Iterable

from casr.errors import PluginError, said_by
from casr.plugins import Plugin, plugins
from emg2vsa.arrays import Floats
from emg2vsa.statistics.clusters import Names
from emg2vsa.statistics.outcome import Outcome

BROKEN = "no result: "
"""Begins the note on a statistic that failed."""


def plugin_outcomes(values: Floats, groups: Names, blocks: Names | None) -> tuple[tuple[str, Outcome], ...]:
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
