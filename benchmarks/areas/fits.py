"""Curves through presses: v = a + b log F, the exponential of a calibration, and NIST's exponentials."""

from __future__ import annotations

from collections.abc import Iterator

from benchmarks.bench.case import Area, Case, Size


def logarithmic(size: Size) -> Iterator[Case]:
    """All presses of a study in one call, beside loops over libraries."""
    from benchmarks.statistics.curve_cases import log_cases

    return log_cases(size)


def exponential(size: Size) -> Iterator[Case]:
    """Refits of a bootstrap."""
    from benchmarks.statistics.curve_cases import exponential_cases

    return exponential_cases(size)


def coverage(size: Size) -> Iterator[Case]:
    """Intervals of b, which correlated samples make too short."""
    from benchmarks.statistics.sample_cases import coverage_cases

    return coverage_cases(size)


def nist_exponential(size: Size) -> Iterator[Case]:
    """The two sets that are exponentials."""
    from benchmarks.statistics.nist_curves import exponential_cases

    return exponential_cases(size)


AREA = Area(
    name="fits",
    question="What do the fits of presses and of calibrations cost, and how many of their digits are right?",
    parts=(logarithmic, exponential, coverage, nist_exponential),
    peers={"lmfit": "lmfit", "statsmodels": "statsmodels", "pingouin": "pingouin"},
    meaning=(
        "A study makes hundreds of logarithmic fits and thousands of exponential refits of one shape: ours does "
        "each set in one call, others loop. The closed form of NumPy shows the floor: it gives a and b without "
        "errors or checks."
    ),
)
