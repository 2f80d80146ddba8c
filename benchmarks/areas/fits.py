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
    peers={"statsmodels": "statsmodels"},
    meaning=(
        "A study makes hundreds of logarithmic fits and thousands of exponential refits of one shape: ours does "
        "each set in one call, libraries loop, and an expert writes the closed form. Ours also leaves out points that "
        "are no numbers, scales extremes and keeps its digits where a fit is close or far from zero."
    ),
)
