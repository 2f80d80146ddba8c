"""Every test of the report beside SciPy, statsmodels, pingouin and scikit-posthocs, with digits."""

from __future__ import annotations

from benchmarks.bench.case import Area, part_of

AREA = Area(
    name="tests",
    question="What do the report's statistical tests cost, and how many digits of them are right?",
    parts=(
        part_of("benchmarks.statistics.group_cases", "group_cases"),
        part_of("benchmarks.statistics.group_cases", "many_values"),
        part_of("benchmarks.statistics.design_cases", "design_cases"),
        part_of("benchmarks.statistics.sample_cases", "sample_cases"),
        part_of("benchmarks.statistics.group_cases", "mixed_cases"),
        part_of("benchmarks.statistics.sample_cases", "anova_cases"),
    ),
    peers={"statsmodels": "statsmodels", "pingouin": "pingouin", "scikit_posthocs": "scikit-posthocs"},
    meaning=(
        "Ours computes all designs of a study in one call, so the ratios grow with their number; the growth "
        "curves show where a single design stands. The digits are those of the worst number that a way returns, "
        "the tail probability as a rule. Where a library gives less than ours, the note of its row says what is "
        "missing. Ours keeps the exact law of Mann and Whitney for two sizes from call to call, as a report asks for "
        "the same sizes again and again; the expert makes it in each call."
    ),
)
