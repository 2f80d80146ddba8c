"""The table over worlds: what is pressed, what is left out, what is counted."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks.tactile import run, worlds
from benchmarks.tactile.world_scores import Found, WorldScore
from benchmarks.tactile.world_tables import kappa_table, world_table
from casr.errors import SettingError
from casr.specimens import SPECIMENS


def test_groups_and_single_worlds_are_asked_by_name() -> None:
    assert worlds.named(["tabulated", "front", "tabulated-frictionless"]) == (
        "tabulated", "tabulated-frictionless", "front",
    )  # fmt: skip
    assert len(worlds.named(["all"])) == 23
    with pytest.raises(SettingError, match="'moon'"):
        worlds.named(["moon"])


def test_a_dome_is_pressed_while_it_is_missing_from_the_library() -> None:
    bench = worlds.world_named("dome-E-stick")
    assert bench.world is not None
    assert not any("E" in dome for dome in bench.library.dome.tolist())
    assert "E" in worlds.world_named("tabulated").library.dome.tolist()


def test_worlds_without_their_tables_are_skipped_with_the_reason(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(worlds, "FULL_TABLES", tmp_path / "contact_fem")
    worlds.world_named.cache_clear()
    try:
        run("presses", n_repetitions=1, worlds=("full",))
    finally:
        worlds.world_named.cache_clear()
    assert capsys.readouterr().out.count("skipped, no contact_fem") == 2


def scores(world: str, bias: float, half: float) -> list[WorldScore]:
    """Of four specimens whose CASR follows the law that calibrates them; the front is off by ``bias``."""
    found = []
    for kappa in (SPECIMENS[name] for name in ("S1", "S2", "S3", "S5")):
        true = (20 + 60 / kappa) ** (2 / 3)
        front = Found(true * (1 + bias), true * (1 + bias) / (1 + half), true * (1 + bias) * (1 + half))
        errors = {1.0: 100 * bias, 2.0: 200 * bias}
        found.append(WorldScore(world, kappa, 0.0, 0, true, "", errors, front, front, model="finite elements"))
    return found


def cells(table: object, row: int) -> dict[str, object]:
    """By heading; of equal headings the first."""
    headings = [heading for heading, _ in table.columns]  # type: ignore[attr-defined]
    found: dict[str, object] = {}
    for heading, cell in zip(headings, table.rows[row], strict=True):  # type: ignore[attr-defined]
        found.setdefault(heading, cell)
    return found


def test_bias_coverage_and_width_of_a_world() -> None:
    row = cells(world_table(scores("one", 0.05, 0.1)), 0)
    assert row["front %"] == pytest.approx(5)
    assert (row["sd"], row["held %"], row["half %"]) == (pytest.approx(0, abs=1e-9), 100, pytest.approx(10))
    assert (row["A(1 N) %"], row["A(2 N) %"], row["A(4 N) %"]) == (pytest.approx(5), pytest.approx(10), None)
    assert cells(world_table(scores("one", 0.05, 0.02)), 0)["held %"] == 0
    both = world_table([*scores("one", 0.0, 0.1), *scores("two", 0.1, 0.02)])
    assert [line[0] for line in both.rows] == ["one", "two", "(all)"]
    assert cells(both, 2)["held %"] == 50


def test_refused_presses_count_as_refused_alone() -> None:
    one, *others = scores("one", 0.0, 0.1)
    refused = WorldScore(one.world, one.stiffness_n_mm, 0.0, 0, one.true_casr, "too small")
    row = cells(world_table([refused, *others]), 0)
    assert (row["n"], row["refused %"], row["held %"]) == (4, 25, 100)
    assert cells(kappa_table([refused, *others]), 0)["none %"] == 100


def test_an_error_that_specimens_share_costs_no_stiffness() -> None:
    row = cells(kappa_table(scores("one", 0.05, 0.1)), 0)
    assert row["exact %"] == pytest.approx(0, abs=1e-6)
    assert row["front %"] == pytest.approx(0, abs=1e-6)
    assert row["held %"] == 100


def test_calibrating_in_one_world_and_pressing_in_another() -> None:
    table = kappa_table([*scores("stick-1", 0.0, 0.1), *scores("stick-2", 0.05, 0.001)])
    names = [row[0] for row in table.rows]
    assert names == ["stick-1", "stick-2", "stick-1 -> stick-2", "stick-2 -> stick-1"]
    crossed = cells(table, 2)
    assert isinstance(crossed["front %"], float)
    assert crossed["front %"] < -10, "5 % of CASR is far more of kappa"
    assert crossed["held %"] == 0
    assert np.isfinite(crossed["exact %"])  # type: ignore[call-overload]
