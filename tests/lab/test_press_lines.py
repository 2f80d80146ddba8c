"""Which presses of a run are over, told while it goes on."""

from __future__ import annotations

import time
from pathlib import Path

import pytest

from emg2vsa.lab import real_press
from emg2vsa.lab.real_press import PressLines


def test_presses_that_are_over_are_told_from_the_log(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A row that has no end yet is no row."""
    monkeypatch.setattr(real_press, "_LOOK_S", 0.005)
    said: list[str] = []
    rows = ["time_s,repetition,phase,depth_mm"]
    with PressLines(tmp_path, 3, said.append):
        for row, news in (
            ("0.5,1,load,1.0", ""),
            ("7.25,1,pause,0.0", "press 1 of 3 done at 7.2 s\n"),
            ("7.35,2,load,0.0", ""),
            ("30.0,3,done,0.0", "press 2 of 3 done at 30.0 s\npress 3 of 3 done at 30.0 s\n"),
        ):
            rows.append(row)
            (tmp_path / "new.csv").write_text("\n".join([*rows, "99.0,3,don"]))
            (tmp_path / "new.csv").replace(tmp_path / "log.csv")
            end_s = time.monotonic() + (60 if news else 0.05)
            heard = ""
            while time.monotonic() < end_s and len(heard) < max(1, len(news)):
                heard += "".join(f"{line}\n" for line in said)
                said.clear()
                time.sleep(0.002)
            assert heard == news, row
    assert said == []
