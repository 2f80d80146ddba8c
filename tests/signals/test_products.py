"""Products in parts: equal to the product at once, whatever the sizes, and never shared among threads."""

from __future__ import annotations

import numpy as np
import pytest

from emg2vsa.signals import products
from emg2vsa.signals.products import times

SIZES = [
    (1, 1, 1, 1), (2, 0, 5, 3), (2, 3, 5, 0), (1, 51, 80, 64), (2, 48, 80, 64), (3, 97, 80, 64), (2, 5000, 64, 8),
    (1, 6000, 4, 4), (1, 40, 300, 200), (1, 3, 9000, 7), (2, 20, 5000, 1), (1, 1, 4096, 3), (1, 2, 4097, 2),
]  # fmt: skip


@pytest.mark.parametrize(("m", "n", "p", "q"), SIZES)
def test_it_is_the_product(m: int, n: int, p: int, q: int) -> None:
    rng = np.random.default_rng(n)
    rows, matrix = rng.standard_normal((m, n + 1, p + 3))[:, 1:, :p], rng.standard_normal((p, q))
    expected = np.einsum("mnp,pq->mnq", rows.astype(np.longdouble), matrix.astype(np.longdouble))
    size = np.einsum("mnp,pq->mnq", np.abs(rows), np.abs(matrix))
    assert (np.abs(times(rows, matrix) - expected) <= 1e-15 * np.sqrt(p) * size + 1e-300).all()


@pytest.mark.parametrize(("m", "n", "p", "q"), SIZES)
def test_no_part_is_large_enough_to_be_shared(monkeypatch: pytest.MonkeyPatch, m: int, n: int, p: int, q: int) -> None:
    asked: list[tuple[int, int, int]] = []
    plain = np.matmul

    def watched(left: np.ndarray, right: np.ndarray, out: np.ndarray) -> np.ndarray:
        asked.append((left.shape[-2], *right.shape))
        return plain(left, right, out=out)

    monkeypatch.setattr(products.np, "matmul", watched)
    times(np.ones((m, n, p)), np.ones((p, q)))
    for rows, long, wide in asked:
        assert rows * long * wide <= 65_536 * 4
        assert long * wide <= 2304 * 4
        assert long <= 10_000
        assert wide > 1 or rows * long <= 2304 * 4
