"""The short stress table keeps its bounds, and breaks where a function is broken."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.stress import all_cases, signals
from benchmarks.stress.case import Case, judged
from emg2vsa.curves import line

SMOKE = tuple(all_cases(smoke=True))


@pytest.mark.parametrize("case", SMOKE, ids=[f"{case.function}: {case.world}" for case in SMOKE])
def test_a_function_keeps_its_bound(case: Case) -> None:
    row = judged(case)
    assert row.kept, row
    assert row.digits >= row.bound or row.said


def test_a_broken_function_breaks_its_row(monkeypatch: pytest.MonkeyPatch) -> None:
    case = next(case for case in SMOKE if case.function.endswith("fit_log") and "1e6" in case.world)
    assert judged(case).verdict == "kept"

    def from_sums(
        values: np.ndarray, weights: object, total: np.ndarray, first: object
    ) -> tuple[np.ndarray, np.ndarray]:
        mean = (np.sum(values, axis=1) / total).astype(np.float32).astype(np.float64)
        return mean, values - mean[:, None]

    monkeypatch.setattr(line, "_centred", from_sums)
    row = judged(case)
    assert row.verdict == "broken"
    assert row.digits < row.bound


def test_a_low_edge_says_its_digits() -> None:
    row = judged(signals.low_pass_case(1e-4, 0.0, 1.0, 2, "causal", 8.0, False, signals.noise(300)))
    assert row.kept
    assert "digits of a slow signal" in row.said
