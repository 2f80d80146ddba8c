"""The mixed model of a balanced study, with and without variance between participants."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from typing import Any

import numpy as np
import pandas as pd

from benchmarks.bench.case import Case, Size, Way
from benchmarks.statistics.exact_tests import mean, mpq, squares
from benchmarks.statistics.numbers import Exact, Numbers, worst_error
from benchmarks.statistics.peers import statsmodels_formula
from emg2vsa.statistics.mixed import balanced_mixed

VOLTS = 1e-5


def mixed_cases(size: Size) -> Iterator[Case]:
    """Fourteen people, five specimens, ten repetitions, in volts."""
    rng = np.random.default_rng(5)
    shape = size.pick((5, 3, 4), (14, 5, 10))
    noise = rng.standard_normal(shape) + 0.5 * np.arange(shape[1])[:, None]
    people = rng.standard_normal((shape[0], 1, 1))
    cells = 0.5 * rng.standard_normal((shape[0], shape[1], 1))
    level = noise - noise.mean(axis=(1, 2), keepdims=True)  # no variance between people at all
    for title, y in (
        ("participants and their specimens differ", noise + people + cells),
        ("no variance between participants (boundary)", level + cells - cells.mean(axis=1, keepdims=True)),
    ):
        ours = Way("emg2vsa", "balanced_mixed", lambda y=VOLTS * y: _ours(y), "equal", "with intervals and checks")
        yield Case(
            f"mixed model in volts, {title}",
            y.size,
            "rows",
            (ours, *_statsmodels(VOLTS * y)),
            worst_error(lambda y=VOLTS * y: _exact(y)),
            "relative",
            "REML of a balanced study in rational arithmetic",
        )


def _ours(y: np.ndarray) -> Numbers:
    found = balanced_mixed(y)
    return {
        "mean": found.mean,
        "var people": found.variance[:1],
        "var cells": found.variance[1:2],
        "var rep": found.variance[2:],
        "F": [found.f],
    }


def _statsmodels(y: np.ndarray) -> Iterator[Way]:
    if statsmodels_formula is None:
        return
    person, specimen, _ = (index.ravel() for index in np.indices(y.shape))
    table = pd.DataFrame({"y": y.ravel(), "person": person, "specimen": specimen})

    def fit(**random: Any) -> Any:
        return statsmodels_formula.mixedlm("y ~ C(specimen)", table, groups="person", **random).fit(reml=True)

    def simple() -> Numbers:
        try:
            return {"mean": _means(fit())}
        except np.linalg.LinAlgError:
            return {"mean": np.full(y.shape[1], np.nan)}

    def nested() -> Numbers:
        try:
            found = fit(re_formula="1", vc_formula={"cell": "0 + C(specimen)"})
        except np.linalg.LinAlgError:
            return {"mean": np.full(y.shape[1], np.nan)}
        numbers = {"var people": found.cov_re.to_numpy()[0], "var cells": found.vcomp, "var rep": [found.scale]}
        return {"mean": _means(found), **numbers}

    yield Way(
        "statsmodels", "MixedLM (1 | person)", simple, "as used", "no variance of cells; a fit that fails has no digits"
    )
    yield Way("statsmodels", "MixedLM, specimens within", nested, "equal", "a fit that fails has no digits")


def _means(fit: Any) -> np.ndarray:
    effects = fit.fe_params.to_numpy()
    return np.concatenate([effects[:1], effects[0] + effects[1:]])


def _exact(y: np.ndarray) -> Exact:
    """The mean squares in rational arithmetic, pooled until in order: REML of a balanced study."""
    n_p, n_s, n_r = y.shape
    values = [[[Fraction(value) for value in cell] for cell in row] for row in y]
    cells = [[mean(cell) for cell in row] for row in values]
    people, specimens = [mean(row) for row in cells], [mean(list(column)) for column in zip(*cells, strict=True)]
    within = sum((squares(cell) for row in values for cell in row), Fraction(0))
    total = n_r * squares([cell for row in cells for cell in row])
    of_people, of_specimens = n_s * n_r * squares(people), n_p * n_r * squares(specimens)
    sums = [within, total - of_people - of_specimens, of_people]
    df = [n_p * n_s * (n_r - 1), (n_p - 1) * (n_s - 1), n_p - 1]
    level = _pooled(sums, df)
    return {
        "mean": {i: mpq(value) for i, value in enumerate(specimens)},
        "var people": {0: mpq((level[2] - level[1]) / (n_s * n_r))},
        "var cells": {0: mpq((level[1] - level[0]) / n_r)},
        "var rep": {0: mpq(level[0])},
        "F": {0: mpq(of_specimens / (n_s - 1) / (sums[1] / df[1]))},
    }


def _pooled(sums: list[Fraction], df: list[int]) -> list[Fraction]:
    """Mean squares that do not fall, neighbours pooled where they would."""
    blocks: list[list[int]] = []

    def level(block: list[int]) -> Fraction:
        return sum((sums[i] for i in block), Fraction(0)) / sum(df[i] for i in block)

    for i in range(len(sums)):
        blocks.append([i])
        while len(blocks) > 1 and level(blocks[-2]) > level(blocks[-1]):
            last = blocks.pop()
            blocks[-1] = blocks[-1] + last
    return [level(block) for block in blocks for _ in block]
