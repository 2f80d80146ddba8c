"""``emg2vsa stats`` as a stranger uses it."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest

from emg2vsa.cli import main

ROWS = [
    (f"P{i}", f"S{j}", j + 0.1 * ((7 * i + 3 * j + 5 * k) % 11)) for i in range(4) for j in range(3) for k in range(5)
]


@pytest.fixture
def table(tmp_path: Path) -> Path:
    path = tmp_path / "slopes.csv"
    path.write_text(
        "participant;specimen;b\n" + "".join(f"{p};{s};{b:.3f}".replace(".", ",") + "\n" for p, s, b in ROWS)
    )
    return path


def test_every_hypothesis_has_its_table(table: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["stats", str(table), "--value", "b", "--group", "specimen", "--block", "participant"]) == 0
    said = capsys.readouterr().out
    assert "b by specimen, 60 rows of 3 groups in 4 blocks (participant)" in said
    for words in (
        "Do groups differ?",
        "Which groups differ?",
        "Are blocks equal?",
        "Effect and interval",
        "Signed ranks over 4 blocks, Holm",
        "Friedman",
    ):
        assert words in said
    assert max(map(len, said.split("Pairs: p of")[0].splitlines()[1:])) <= 124
    assert "\N{NO-BREAK SPACE}" not in said


def test_json_holds_every_outcome(table: Path, capsys: pytest.CaptureFixture[str]) -> None:
    arguments = [
        "stats",
        str(table),
        "--value",
        "b",
        "--group",
        "specimen",
        "--block",
        "participant",
        "--margin",
        "0.5",
    ]
    assert main([*arguments, "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    methods = {outcome["method"] for outcome in said["outcomes"]}
    for method in (
        "Lilliefors", "Shapiro-Wilk", "one-way ANOVA", "Welch's analysis of variance", "Games-Howell", "Tukey's HSD",
        "Fisher's LSD, pooled SD", "TOST, pooled variance", "linear mixed model, balanced, exact REML",
    ):  # fmt: skip
        assert method in methods
    assert {"apa", "ieee", "latex", "plain"} == set(said["outcomes"][0]["text"])
    assert len(said["hypotheses"]) == 6
    assert [group["n"] for group in said["groups"]] == [20, 20, 20]


def test_without_columns_they_are_listed(table: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["stats", str(table)]) == 0
    said = capsys.readouterr().out
    assert "numbers" in said
    assert "specimen" in said


def test_protection_is_named(table: Path, capsys: pytest.CaptureFixture[str]) -> None:
    main(["stats", str(table), "--value", "b", "--group", "specimen", "--protected"])
    assert "protected by the F test" in capsys.readouterr().out.replace("\n", " ").replace("  ", " ")


def test_rows_left_out_are_said(table: Path, capsys: pytest.CaptureFixture[str]) -> None:
    table.write_text(table.read_text() + "P9;S1;\nP9;;1,5\n")
    assert main(["stats", str(table), "--value", "b", "--group", "specimen"]) == 0
    said = capsys.readouterr().out
    assert "note: 1 row without a number left out" in said
    assert "note: 1 row without a group or block left out" in said


def test_nist_digits_survive_the_command_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """1000000000000.4 is no float64: only exact differences give F = 2 here."""
    path = tmp_path / "large.csv"
    path.write_text("g,b\n" + "".join(f"{g},1000000000000.{d}\n" for g, d in zip("aabb", "2435", strict=True)))
    assert main(["stats", str(path), "--value", "b", "--group", "g", "--json"]) == 0
    outcomes = json.loads(capsys.readouterr().out)["outcomes"]
    (f,) = [outcome["statistic"] for outcome in outcomes if outcome["method"] == "one-way ANOVA"]
    assert math.isclose(f, 0.5, rel_tol=1e-14)
