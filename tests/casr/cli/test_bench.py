"""``casr bench``: hands on what was asked."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from casr.cli import main


def test_options_reach_the_bench(monkeypatch: pytest.MonkeyPatch) -> None:
    import casr.bench

    asked: list[Any] = []
    monkeypatch.setattr(casr.bench, "run", lambda *args, **kwargs: asked.append((args, kwargs)))
    assert main(["bench", "presses", "--out", "d", "--repetitions", "2", "--jobs", "3"]) == 0
    assert asked == [(("presses", Path("d")), {"n_seeds": 6, "n_repetitions": 2, "n_jobs": 3})]


def test_an_unknown_kind_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["bench", "weather"])
    assert "flow" in capsys.readouterr().err
