"""Kappa on the page: what is read of a kappa.csv that grows, and what the browser makes of it."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest

from emg2vsa.errors import RecordingError
from emg2vsa.live.tails import KappaTail
from emg2vsa.rig.kappa.live_kappa import KAPPA_FILE, KAPPA_HEADER, KappaRow, line_of

VIEW = {
    "repetition": 2, "presses": 2, "force_n": [1.1, 1.5, 2.0], "kappa_n_per_mm": [3.1, 3.3, 3.35],
    "low_n_per_mm": [1.0, 2.0, 2.5], "high_n_per_mm": [None, 5.0, 4.4], "half_width": 0.284,
    "stop": "", "stop_n": None, "note": "",
}  # fmt: skip


def row(**changes: Any) -> KappaRow:
    values: dict[str, Any] = {
        "time_s": 1.0, "repetition": 1, "frame": 0, "force_n": 1.0, "area": 10.0, "kappa_n_per_mm": math.nan,
        "low_n_per_mm": math.nan, "high_n_per_mm": math.nan, "half_width": math.nan, "presses": 0,
        "judged_at_n": math.nan, "cues": "area", "reachable": math.nan, "stop": "",
        "latency_s": math.nan,
    }  # fmt: skip
    return KappaRow(**(values | changes))


def test_it_follows_the_newest_press(tmp_path: Path) -> None:
    file, tail = tmp_path / KAPPA_FILE, KappaTail(tmp_path)
    assert tail.look() is None
    file.write_text(f"{KAPPA_HEADER}\n")
    assert tail.look() is None
    told = {"kappa_n_per_mm": 3.3, "low_n_per_mm": 2.0, "high_n_per_mm": math.inf, "half_width": math.inf}
    text = line_of(row()) + line_of(row(frame=1, force_n=2.0, presses=1, **told))
    with file.open("a") as rows:
        rows.write(text[:-5])
        rows.flush()
        first = tail.look()
        rows.write(text[-5:])
        rows.flush()
        second = tail.look()
        third = line_of(row(repetition=2, frame=0, stop="", note="pins lost"))
        stopped = line_of(row(repetition=2, frame=1, force_n=1.5, presses=2, stop="width reached", **told))
        later = line_of(row(repetition=2, frame=2, force_n=1.9, presses=2, stop="width reached", **told))
        rows.write(third + stopped + later)
    assert first is not None
    assert (first.repetition, first.kappa_n_per_mm) == (1, [])
    assert second is not None
    assert (second.force_n, second.kappa_n_per_mm, second.high_n_per_mm, second.half_width) == (
        [2],
        [3.3],
        [None],
        None,
    )
    newest = tail.look()
    assert newest is not None
    assert (newest.repetition, newest.presses, newest.force_n) == (2, 2, [1.5, 1.9])
    assert (newest.stop, newest.stop_n) == ("width reached", 1.5)
    assert tail.look() == newest


def test_another_file_is_said(tmp_path: Path) -> None:
    (tmp_path / KAPPA_FILE).write_text("a,b\n1,2\n")
    with pytest.raises(RecordingError, match=r"kappa\.csv: expected rows of kappa"):
        KappaTail(tmp_path).look()


@pytest.fixture
def computed(computed_by: Any) -> Any:
    return computed_by("watch")


@pytest.mark.parametrize(
    ("changes", "big", "interval", "judged"),
    [
        ({}, "3.35 N/mm", "2.50 to 4.40 N/mm (±28 %)", "press 2 · 2 presses count"),
        ({"presses": 1}, "3.35 N/mm", "2.50 to 4.40 N/mm (±28 %)", "press 2 · 1 press counts"),
        ({"high_n_per_mm": [1, 1, None], "half_width": None}, "3.35 N/mm", "2.50 to rigid N/mm", None),
        ({"stop": "width reached", "stop_n": 1.5}, "3.35 N/mm", None,
         "press 2 · 2 presses count · seen enough at 1.50 N: width reached"),
        ({"kappa_n_per_mm": []}, "–", "", "not determined yet"),
        ({"kappa_n_per_mm": [], "note": "pins lost"}, "–", "", "pins lost"),
    ],
)  # fmt: skip
def test_in_words(computed: Any, changes: dict[str, Any], big: str, interval: str | None, judged: str | None) -> None:
    found = computed("kappaOf", VIEW | changes)
    assert found["big"] == big
    assert interval is None or found["interval"] == interval
    assert judged is None or found["judged"] == judged


def test_the_plot_holds_the_newest_interval_and_cuts_endless_ones(computed: Any) -> None:
    found = computed("kappaAxisOf", VIEW, 7)
    assert found["high"] >= 4.4
    assert found["tops"][0] > found["high"]
    assert found["tops"][1:] == [5.0, 4.4]
    assert [label["text"] for label in found["axis"]["labels"]][:3] == ["0", "1 N", "2 N"]
    assert computed("kappaAxisOf", VIEW | {"kappa_n_per_mm": [], "high_n_per_mm": []}, 7)["high"] > 0
    assert computed("newestBarOf", VIEW | {"kappa_n_per_mm": []}, []) == []
    (bar,) = computed("newestBarOf", VIEW, found["tops"])
    assert (bar["at"], bar["low"], bar["value"], bar["high"]) == (2.0, 2.5, 3.35, 4.4)
