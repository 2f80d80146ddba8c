"""The tables of the arithmetic on one seed."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.tactile import numerics
from benchmarks.tactile.table import Table


def numbers(table: Table) -> list[float]:
    return [cell for row in table.rows for cell in row if isinstance(cell, (int, float))]


def test_identical_frames_have_no_divergence() -> None:
    assert numbers(numerics.identical_table()) == [0.0, 0.0, 0.0]


def test_single_precision_is_near_double_where_alpha_is_sensible() -> None:
    rows = {row[0]: row[1] for row in numerics.precision_table().rows}
    assert all(0 < rows[alpha] < 1e-3 for alpha in ("10", "30", "60", "100"))


@pytest.mark.parametrize("table", [numerics.settings_table, numerics.scene_table])
def test_tables_over_settings_and_scenes_are_finite(table: object) -> None:
    found = numbers(table(1))  # type: ignore[operator]
    assert len(found) > 40
    assert np.isfinite(found).all()


def test_streaming_times_are_positive(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(numerics, "STREAMED_FRAMES", (5, 10))
    assert all(row[1] > 0 for row in numerics.streaming_table().rows)  # type: ignore[operator]
