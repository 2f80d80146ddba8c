"""How runs, designs and areas are called in tables, figures and sentences."""

from __future__ import annotations

from emg2vsa.discrimination.run_table import RunTable
from emg2vsa.discrimination.separation import Gaps
from emg2vsa.report.wording import UNDEFINED, bounded, number
from emg2vsa.stats.bootstrap import Bootstrap

_UNITS = {"mm2": "mm²", "px2": "px²"}
SIMULATED = "Simulated rig."
"""Ends the caption of a figure, or of a table, of emulated runs."""


def area_unit(unit: str) -> str:
    """mm² or px²."""
    return _UNITS.get(unit, unit)


def design_name(table: RunTable, design: int) -> str:
    """``modular, 30°``."""
    return f"{table.conditions[design]}, {table.angles_deg[design]:g}°"


def interval(estimate: float, low: float, high: float) -> str:
    """``3.01 [1.70, 4.23]``."""
    return UNDEFINED if estimate != estimate else f"{number(estimate)} [{number(low)}, {number(high)}]"


def interval_of(found: Bootstrap, i: int) -> tuple[float, float, float]:
    """Estimate, low and high."""
    return float(found.estimate[i]), float(found.low[i]), float(found.high[i])


def gap_of(found: Gaps, i: int) -> tuple[float, float, float]:
    """Gap, low and high."""
    return float(found.gap[i]), float(found.low[i]), float(found.high[i])


def exact_p(p: float) -> str:
    """As the paper prints a p: four decimals, two digits below .0001."""
    return bounded(p, 4) if p >= 1e-4 or p != p else number(p, 2)
