"""``casr bench``: hands on what was asked."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

import benchmarks.tactile
from casr.cli import bench, main


def test_options_reach_the_bench(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[Any] = []
    monkeypatch.setattr(benchmarks.tactile, "run", lambda *args, **kwargs: asked.append((args, kwargs)))
    assert main(["bench", "presses", "--out", "d", "--repetitions", "2", "--jobs", "3"]) == 0
    assert asked == [(("presses", Path("d")), {"n_seeds": 6, "n_repetitions": 2, "n_jobs": 3})]


def test_an_unknown_kind_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["bench", "weather"])
    assert "flow" in capsys.readouterr().err


def test_without_a_checkout_it_says_where_the_benchmarks_are(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(bench, "SOURCE", tmp_path)
    assert main(["bench"]) == 2
    complaint = capsys.readouterr().err
    assert complaint.count("\n") == 1
    assert "benchmarks/ beside" in complaint
    assert "Get the sources of emg2vsa" in complaint
