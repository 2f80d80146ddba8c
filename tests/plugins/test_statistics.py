"""A statistic of another package: after our own tests, under its name; a broken one takes nothing from them."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import alexandergovern

import emg2vsa
from emg2vsa.cli import main

Install = Callable[..., Path]

BY = "by alexander-govern of lab-tools 1.0"


@pytest.fixture
def table(tmp_path: Path) -> tuple[Path, dict[str, np.ndarray]]:
    rng = np.random.default_rng(2)
    groups = {
        name: np.round(rng.normal(mean, 1 + mean / 4, 8), 4) for name, mean in (("A", 1.0), ("B", 2.0), ("C", 2.5))
    }
    path = tmp_path / "table.csv"
    rows = [f"{name},P{i % 4},{x}" for name, of in groups.items() for i, x in enumerate(of)]
    path.write_text("\n".join(["specimen,participant,b", *rows]) + "\n")
    return path, groups


def test_it_is_shown_everywhere_under_its_name(
    install: Install, table: tuple[Path, dict[str, np.ndarray]], capsys: pytest.CaptureFixture[str]
) -> None:
    path, groups = table
    wanted = alexandergovern(*groups.values())
    words = ["stats", str(path), "--value", "b", "--group", "specimen", "--block", "participant"]
    assert main([*words, "--json"]) == 0
    without = json.loads(capsys.readouterr().out)
    install()
    assert main(words) == 0
    assert f"{BY}\n  Alexander-Govern: A" in capsys.readouterr().out
    assert main([*words, "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    *ours, last = told["outcomes"]
    assert ours == without["outcomes"]
    assert (last["of"], last["n"]) == (BY, 24)
    assert last["statistic"] == pytest.approx(wanted.statistic, rel=1e-12)
    row = emg2vsa.stats(path, value="b", group="specimen").iloc[-1]
    assert (row["of"], row["p"]) == (BY, pytest.approx(wanted.pvalue, rel=1e-12))


BROKEN = {
    "import no_such_module_at_all": "expected a module that can be imported, but found ModuleNotFoundError",
    "def alexander_govern(*given): 1 / 0": "expected a statistic of these values, but found ZeroDivisionError",
    "def alexander_govern(*given): return 0.05": "expected an Outcome or several, but found 0.05",
    "def alexander_govern(*given): return ['p']": "expected an Outcome or several, but found 'p'",
    "alexander_govern = 1": "expected a statistic of these values, but found TypeError",
}


@pytest.mark.parametrize("code", BROKEN)
def test_a_broken_one_is_named_and_the_others_stay(
    install: Install, table: tuple[Path, dict[str, np.ndarray]], code: str, capsys: pytest.CaptureFixture[str]
) -> None:
    path, _ = table
    install(code=code)
    assert main(["stats", str(path), "--value", "b", "--group", "specimen"]) == 1
    said = capsys.readouterr()
    assert "One-way ANOVA" in said.out
    assert "Traceback" not in said.err
    assert f"no result: plugin alexander-govern of lab-tools 1.0: {BROKEN[code]}" in said.out
    row = emg2vsa.stats(path, value="b", group="specimen").iloc[-1]
    assert np.isnan(row["p"])
    assert BROKEN[code] in row["notes"]


def test_a_statistic_cannot_change_what_others_get(install: Install, table: tuple[Path, dict[str, np.ndarray]]) -> None:
    path, _ = table
    ours = emg2vsa.stats(path, value="b", group="specimen")
    install(code="def alexander_govern(values, groups, blocks):\n    values[:] = 0\n    return []\n")
    assert emg2vsa.stats(path, value="b", group="specimen").equals(ours)
