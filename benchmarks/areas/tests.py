"""Every test of the report beside SciPy, statsmodels, pingouin and scikit-posthocs, with digits."""

from __future__ import annotations

from collections.abc import Iterator

from benchmarks.bench.case import Area, Case, Size


def means_and_ranks(size: Size) -> Iterator[Case]:
    """Analyses of variance, Kruskal-Wallis, Mann-Whitney."""
    from benchmarks.statistics.group_cases import group_cases

    return group_cases(size)


def many_groups_and_values(size: Size) -> Iterator[Case]:
    """Mann-Whitney where there is much of it."""
    from benchmarks.statistics.group_cases import many_values

    return many_values(size)


def unequal_and_paired(size: Size) -> Iterator[Case]:
    """Welch, Games-Howell, repeated measures, Friedman, equivalence, bootstrap."""
    from benchmarks.statistics.design_cases import design_cases

    return design_cases(size)


def normality(size: Size) -> Iterator[Case]:
    """Kolmogorov-Smirnov, Lilliefors, Shapiro-Wilk."""
    from benchmarks.statistics.sample_cases import sample_cases

    return sample_cases(size)


def mixed_models(size: Size) -> Iterator[Case]:
    """Balanced mixed models, inside and at the boundary."""
    from benchmarks.statistics.group_cases import mixed_cases

    return mixed_cases(size)


def nist(size: Size) -> Iterator[Case]:
    """NIST's analyses of variance."""
    from benchmarks.statistics.sample_cases import anova_cases

    return anova_cases(size)


AREA = Area(
    name="tests",
    question="What do the report's statistical tests cost, and how many digits of them are right?",
    parts=(means_and_ranks, many_groups_and_values, unequal_and_paired, normality, mixed_models, nist),
    peers={"statsmodels": "statsmodels", "pingouin": "pingouin", "scikit_posthocs": "scikit-posthocs"},
    meaning=(
        "Ours computes all designs of a study in one call, so the ratios grow with their number; the growth "
        "curves show where a single design stands. The digits are those of the worst number that a way returns, "
        "the tail probability as a rule. Where a library gives less than ours, the note of its row says what is "
        "missing."
    ),
)
