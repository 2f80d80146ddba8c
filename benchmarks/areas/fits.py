"""Curves through presses: v = a + b log F, the exponential of a calibration, and NIST's exponentials."""

from __future__ import annotations

from benchmarks.bench.case import Area, part_of

AREA = Area(
    name="fits",
    question="What do the fits of presses and of calibrations cost, and how many of their digits are right?",
    parts=(
        part_of("benchmarks.statistics.curve_cases", "log_cases"),
        part_of("benchmarks.statistics.curve_cases", "exponential_cases"),
        part_of("benchmarks.statistics.sample_cases", "coverage_cases"),
        part_of("benchmarks.statistics.curve_cases", "nist_exponential_cases"),
    ),
    peers={"lmfit": "lmfit", "statsmodels": "statsmodels"},
    meaning=(
        "A study makes hundreds of logarithmic fits and thousands of exponential refits of one shape: ours does "
        "each set in one call, others loop. The closed form of NumPy shows the floor: it gives a and b without "
        "errors or checks."
    ),
)
