"""Several crossed factors: against statsmodels, one-way analysis, exact arithmetic; and with empty cells."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from emg2vsa.errors import DataError
from emg2vsa.statistics.anova import one_way
from emg2vsa.statistics.factorial import Factorial, factorial


def design(seed: int, shape: tuple[int, ...] = (2, 3, 4), least: int = 2) -> tuple[np.ndarray, dict[str, list[str]]]:
    """Unequal cells of ``least`` to 5 values."""
    rng = np.random.default_rng(seed)
    names = ("condition", "angle", "specimen")[: len(shape)]
    rows = [place for place in np.ndindex(*shape) for _ in range(rng.integers(least, 6))]
    levels = {name: [f"{name}{row[i]}" for row in rows] for i, name in enumerate(names)}
    y = rng.standard_normal(len(rows)) + np.array([row[0] * 0.5 + row[-1] * 0.3 * row[0] for row in rows])
    return y, levels


def by_name(found: Factorial, name: str) -> int:
    return found.effects.index(name)


@pytest.mark.parametrize("seed", [0, 1])
def test_statsmodels_says_the_same_of_unequal_cells(seed: int) -> None:
    statsmodels = pytest.importorskip("statsmodels.formula.api")
    pandas = pytest.importorskip("pandas")
    from statsmodels.stats.anova import anova_lm

    y, levels = design(seed)
    found = factorial(y, levels)
    formula = "y ~ C(condition, Sum) * C(angle, Sum) * C(specimen, Sum)"
    peer = anova_lm(statsmodels.ols(formula, pandas.DataFrame({"y": y, **levels})).fit(), typ=2)
    for row, (squares, df, f, p) in zip(peer.index, peer.to_numpy(), strict=True):
        if row == "Residual":
            assert found.error_df == df
            continue
        i = by_name(found, " × ".join(part[2:].split(",")[0] for part in row.split(":")))
        assert (found.df[i], found.f[i]) == pytest.approx((df, f), rel=1e-10)
        assert found.p[i] == pytest.approx(p, rel=1e-9)
        assert found.eta2[i] == pytest.approx(squares / (squares + peer["sum_sq"]["Residual"]), rel=1e-12)


def test_one_factor_is_the_one_way_analysis() -> None:
    y, levels = design(3, (4,))
    found = factorial(y, levels)
    rows = np.full((4, 5), np.nan)
    for i in range(4):
        own = y[np.array(levels["condition"]) == f"condition{i}"]
        rows[i, : own.size] = own
    anova = one_way(rows)
    assert (found.f[0], found.p[0], found.eta2[0]) == pytest.approx((anova.f[0], anova.p[0], anova.eta2[0]), rel=1e-12)


def test_a_balanced_design_in_rational_numbers() -> None:
    rng = np.random.default_rng(5)
    y = rng.integers(0, 50, (2, 3, 4)).astype(float)
    a, b, _ = (index.ravel() for index in np.indices(y.shape))
    found = factorial(y.ravel(), {"a": a.tolist(), "b": b.tolist()})
    exact = [[[Fraction(int(v)) for v in cell] for cell in row] for row in y]
    grand = sum(v for row in exact for cell in row for v in cell) / 24
    rows = [sum(v for cell in row for v in cell) / 12 for row in exact]
    columns = [sum(v for row in exact for v in row[j]) / 8 for j in range(3)]
    cells = [[sum(cell) / 4 for cell in row] for row in exact]
    within = sum((v - cells[i][j]) ** 2 for i in range(2) for j in range(3) for v in exact[i][j])
    squares = (
        12 * sum((m - grand) ** 2 for m in rows),
        8 * sum((m - grand) ** 2 for m in columns),
        4 * sum((cells[i][j] - rows[i] - columns[j] + grand) ** 2 for i in range(2) for j in range(3)),
    )
    for i, (square, df) in enumerate(zip(squares, (1, 2, 2), strict=True)):
        assert found.f[i] == pytest.approx(float(square / df / (within / 18)), rel=1e-13)


def test_empty_cells_cost_degrees_of_freedom_and_are_told() -> None:
    """Two conditions at all angles, a third at the first angle only."""
    y, levels = design(7, (3, 3, 2))
    keep = np.array(
        [c != "condition2" or a == "angle0" for c, a in zip(levels["condition"], levels["angle"], strict=True)]
    )
    found = factorial(y[keep], {name: np.array(of)[keep].tolist() for name, of in levels.items()})
    df = dict(zip(found.effects, found.df.tolist(), strict=True))
    assert df == {
        "condition": 2, "angle": 2, "specimen": 1, "condition × angle": 2, "condition × specimen": 2,
        "angle × specimen": 2, "condition × angle × specimen": 2,
    }  # fmt: skip
    assert sum(df.values()) + found.error_df == np.count_nonzero(keep) - 1


def test_an_effect_that_cannot_be_told_apart_is_undefined() -> None:
    """Condition and angle change together."""
    y, levels = design(8, (2, 3))
    keep = np.array([c[-1] == a[-1] for c, a in zip(levels["condition"], levels["angle"], strict=True)])
    found = factorial(y[keep], {name: np.array(of)[keep].tolist() for name, of in levels.items()})
    assert found.df.tolist() == [0, 0, 0]
    assert np.isnan(found.p).all()


@pytest.mark.parametrize(("shift", "scale"), [(2.0**30, 1.0), (0.0, 1e-150), (0.0, 1e150)])
def test_origin_and_unit(shift: float, scale: float) -> None:
    y, levels = design(9)
    y = np.round(y * 1024) / 1024  # so that the shift is exact
    found, other = factorial(y, levels), factorial((y + shift) * scale, levels)
    np.testing.assert_allclose(other.f, found.f, rtol=1e-11)
    np.testing.assert_allclose(other.omega2, found.omega2, rtol=1e-10, atol=1e-15)


@pytest.mark.parametrize(
    ("tries", "most", "low", "high"),
    [(200, 0.105, 0.91, 0.99), pytest.param(400, 0.085, 0.915, 0.985, marks=pytest.mark.slow)],
)
def test_size_and_coverage_of_the_share(tries: int, most: float, low: float, high: float) -> None:
    """If 88 % were covered instead of 95 %, it would fail for 93 % of samples of 200 and 99 % of those of 400."""
    rejected, inside = 0, 0
    _, levels = design(11, (2, 3), least=3)
    a = np.array([name[-1] for name in levels["condition"]]).astype(float)
    n = a.size
    for seed in range(tries):
        noise = np.random.default_rng(seed).standard_normal(n)
        rejected += factorial(noise, levels).p[0] < 0.05
        found = factorial(noise + 0.8 * a, levels)
        b = np.array(levels["angle"])
        share = sum(
            0.8**2 / (1 / np.sum((a == 0) & (b == level)) + 1 / np.sum((a == 1) & (b == level)))
            for level in np.unique(b)
        )
        inside += found.low[0] <= share / (share + n) <= found.high[0]
    assert 0 < rejected / tries < most
    assert low < inside / tries < high


@pytest.mark.parametrize(
    ("values", "factors", "wanted"),
    [
        ([1.0, 2.0], {}, "one to four factors"),
        ([1.0, 2.0], {"a": ["x"]}, "for each of 2 values"),
        ([1.0, 2.0, 3.0], {"a": ["x", "x", "x"]}, "two levels of a"),
        ([1.0, np.nan], {"a": ["x", "y"]}, "two levels of a"),
        (np.arange(60.0), {"a": list(range(60)), "b": list(range(60))}, "fewer than 2000"),
    ],
)
def test_designs_that_are_none_are_refused(values: list[float], factors: dict[str, list[str]], wanted: str) -> None:
    with pytest.raises(DataError) as raised:
        factorial(values, factors)
    assert wanted in str(raised.value)


def test_values_without_scatter() -> None:
    levels = {"a": [0, 0, 1, 1]}
    assert np.isnan(factorial([1.0, 1.0, 1.0, 1.0], levels).f[0])
    assert np.isinf(factorial([1.0, 1.0, 2.0, 2.0], levels).f[0])
