"""Who judges the presses of a run: its own process where time is virtual, `OwnProcess` beside it where time is real."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Protocol, TextIO

import numpy as np

from casr.atomic import write_text_atomic
from emg2vsa.calibration.online import NO_GAIN, WIDTH_REACHED
from emg2vsa.calibration_file import sha256_of
from emg2vsa.devices.protocols import Frame, PressJudge
from emg2vsa.rig.kappa.live_kappa import (
    KAPPA_HEADER,
    Held,
    KappaPlan,
    KappaRow,
    LiveKappa,
    Tally,
    line_of,
)
from emg2vsa.rig.record.new_folder import KAPPA_ABOUT_FILE


class KappaJudge(PressJudge, Protocol):
    """Keeps the account of what it was shown."""

    tally: Tally

    def close(self) -> None:
        """The run is over."""


class SameProcess:
    """Answers each frame before the run goes on: the same run gives the same rows.

    Parameters
    ----------
    plan : how presses are judged. file : where rows go.
    """

    def __init__(self, plan: KappaPlan, file: Path) -> None:
        self.tally = Tally()
        self._kappa, self._held, self._stop = LiveKappa(plan), Held(), _Stops()
        self._rows = new_rows(file)

    def force(self, time_s: float, force_n: float, depth_mm: float) -> None:
        self._held.force(time_s, force_n, depth_mm)
        self._answer(over=False)

    def frame(self, repetition: int, frame: Frame) -> None:
        self.tally.frames += 1
        self._held.frame(repetition, frame)

    def stop(self, repetition: int) -> str:
        return self._stop.of(repetition)

    def press_over(self) -> None:
        self._answer(over=True)
        if not self.tally.trouble:
            self._kappa.press_over()

    def close(self) -> None:
        self._rows.close()

    def _answer(self, *, over: bool) -> None:
        for repetition, frame, readings in self._held.ready(over=over):
            if self.tally.trouble:
                return
            try:
                row = self._kappa.frame(repetition, frame.time_s, frame.image, readings)
                self._kappa.settle()
                self._rows.write(line_of(row))
                self._stop.see(row)
            except Exception as error:  # whatever goes wrong here, the press goes on
                self.tally.trouble = f"{type(error).__name__}: {error}"
                return
            self.tally.answered += 1


class _Stops:
    def __init__(self) -> None:
        self._word = 0

    def see(self, row: KappaRow) -> None:
        self._word = stop_word(row) or self._word

    def of(self, repetition: int) -> str:
        return stop_text(self._word, repetition)


_REASONS = (WIDTH_REACHED, NO_GAIN)
_REASON_BITS, _WIDTH_BITS = 4, 20
_OPEN = 2**_WIDTH_BITS - 1
"""In place of a half width that is not finite."""


def stop_word(row: KappaRow) -> int:
    """Repetition, reason and half width in one number of 8 bytes, which is written at once; 0 while a press goes on."""
    if row.stop not in _REASONS:
        return 0
    permille: int = min(round(1000 * row.half_width), _OPEN - 1) if np.isfinite(row.half_width) else _OPEN
    return (row.repetition << _REASON_BITS | _REASONS.index(row.stop)) << _WIDTH_BITS | permille


def stop_text(word: int, repetition: int) -> str:
    """Why this press stops, with the width it has reached; empty for another press, or none."""
    head, permille = divmod(word, 2**_WIDTH_BITS)
    number, reason = divmod(head, 2**_REASON_BITS)
    if word == 0 or number != repetition:
        return ""
    return f"{_REASONS[reason]}, kappa " + ("open to rigid" if permille == _OPEN else f"to {permille / 10:g} %")


def new_rows(file: Path) -> TextIO:
    """A new kappa.csv. OSError where there is one."""
    rows = file.open("x", encoding="utf-8", newline="")
    rows.write(f"{KAPPA_HEADER}\n")
    return rows


def write_about(folder: Path, plan: KappaPlan, tally: Tally) -> None:
    """kappa.json beside kappa.csv: by which calibration, and what became of the frames."""
    own = plan.calibration
    document = {
        "calibration": plan.name,
        "sha256": sha256_of(own),
        "specimens": list(own.specimens),
        "known_presses": own.presses,
        "quantity": own.quantity,
        "area_unit": own.area_unit,
        "angle_deg": own.angle_deg,
        "condition": own.condition,
        "simulated": own.simulated,
        "stop_at": plan.stop_at,
        **tally.about(),
    }
    write_text_atomic(folder / KAPPA_ABOUT_FILE, json.dumps(document, indent=2) + "\n")
