"""Which mounting a run of an unknown specimen gets, and when a hand is needed."""

from __future__ import annotations

from pathlib import Path

from emg2vsa.calibration.next_press import Choice
from emg2vsa.lab.adaptive_runs import Bench, mounted
from emg2vsa.lab.person import Person
from emg2vsa.rig_file.plans import Run


def test_only_another_angle_motor_or_mounting_needs_a_hand(tmp_path: Path) -> None:
    asked: list[str] = []

    def ask(question: str) -> str:
        asked.append(question)
        return ""

    soft, stiff, tilted = (
        Run("S3", angle_deg, condition)
        for angle_deg, condition in ((0.0, "constant-min"), (0.0, "modular"), (30.0, "modular"))
    )
    (tmp_path / "S3_0_modular").mkdir()
    runs, bench = (soft, stiff, tilted), Bench()

    def place(calibration: int, *, remount: bool) -> tuple[int, bool]:
        choice = Choice(calibration, 1, remount, 0.1, 1.0, True)
        return mounted(bench, choice, runs, tmp_path, Person(ask=ask))

    assert place(0, remount=True) == (1, True)
    assert len(asked) == 1, "two angles: where the specimen is to lie is said"
    assert place(1, remount=True) == (2, True), "one is there already"
    assert place(0, remount=False) == (1, False)
    assert len(asked) == 1
    (tmp_path / "S3_0_constant-min").mkdir()
    assert place(0, remount=True) == (2, True)
    assert asked[1:] == ["Mount anew S3 at 0 degrees under the qbmove, then press Enter. "]
    assert place(2, remount=True) == (1, True)
    assert asked[2:] == ["Put S3 at 30 degrees under the qbmove, then press Enter. "]
