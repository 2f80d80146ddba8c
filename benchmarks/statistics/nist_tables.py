"""Digits on NIST's Statistical Reference Datasets."""

from __future__ import annotations

from dataclasses import dataclass

from benchmarks.statistics.digit_table import DigitTable
from benchmarks.statistics.nist_curves import exponential_digits, linear_table, nonlinear_table
from benchmarks.statistics.nist_samples import anova_table, univariate_table


@dataclass(frozen=True)
class NistTables:
    """None, or empty, where the data are absent."""

    anova: DigitTable | None
    nonlinear: DigitTable | None
    exponential: dict[str, float]


def nist_tables() -> NistTables:
    """All of them, printed."""
    anova, linear, nonlinear, univariate = anova_table(), linear_table(), nonlinear_table(), univariate_table()
    for table in (anova, linear, nonlinear, univariate):
        if table is not None:
            table.show()
    return NistTables(anova, nonlinear, exponential_digits())
