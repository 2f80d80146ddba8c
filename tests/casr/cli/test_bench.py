"""``casr bench``: hands on what was asked."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

import benchmarks.tactile
from benchmarks.tactile.table import Table
from casr import source_checkout
from casr.cli import main


def test_options_reach_the_bench(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[Any] = []
    monkeypatch.setattr(benchmarks.tactile, "run", lambda *args, **kwargs: asked.append((args, kwargs)))
    assert main(["bench", "presses", "--out", "d", "--repetitions", "2", "--jobs", "3"]) == 0
    words = {"n_seeds": 6, "n_repetitions": 2, "n_jobs": 3, "show": True}
    assert main(["bench", "presses", "--world", "tabulated,front"]) == 0
    assert asked == [
        (("presses", Path("d")), words | {"worlds": ()}),
        (("presses", None), words | {"n_repetitions": 10, "n_jobs": 1, "worlds": ("tabulated", "front")}),
    ]


def test_json_holds_the_tables_and_nothing_else(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    table = Table("flow", "Flow", (("way", ""), ("ms", ".2f")), [("ours", 1.5), ("theirs", None)], ("a note",))
    monkeypatch.setattr(benchmarks.tactile, "_measured", lambda *args: [table])
    assert main(["bench", "numerics", "--json"]) == 0
    (found,) = json.loads(capsys.readouterr().out)["tables"]
    assert (found["name"], found["rows"], found["notes"]) == ("flow", [["ours", 1.5], ["theirs", None]], ["a note"])


@pytest.mark.parametrize(
    ("words", "complaint"),
    [(["presses", "--world", "tabulated,moon"], "'moon'"), (["numerics", "--world", "tabulated"], "with presses")],
)
def test_worlds_that_cannot_be(words: list[str], complaint: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bench", *words]) == 2
    assert complaint in capsys.readouterr().err


def test_an_unknown_kind_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["bench", "weather"])
    assert "numerics" in capsys.readouterr().err


def test_without_a_checkout_it_says_where_the_benchmarks_are(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(source_checkout, "SOURCE", tmp_path)
    assert main(["bench"]) == 2
    complaint = capsys.readouterr().err
    assert complaint.count("\n") == 1
    assert "benchmarks/ beside" in complaint
    assert "Get the sources of emg2vsa" in complaint
