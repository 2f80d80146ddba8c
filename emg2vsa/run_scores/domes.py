"""Whose tables the front of a press is found by, apart from what finds it: whoever calibrates scores nothing."""

from __future__ import annotations

from typing import NamedTuple

from casr.dome.tables import USUAL_HEIGHT_MM


class Domes(NamedTuple):
    """Whose tables the front is found by: a sensor's own, on specimens of this height; see ``casr.ScoreSettings``."""

    domes: str | None = None
    specimen_height_mm: float | None = None


NO_DOMES = Domes()
"Those that come with casr."
ALIKE = 0.1
"Share of 25 mm by which a specimen may differ from those of the tables that come with casr: 1 to 2 % of the area."


def notes_on_height(height_mm: float | None) -> tuple[str, ...]:
    """Notes on a specimen of this height, mm, that is scored by the tables that come with casr."""
    if height_mm is None or abs(height_mm / USUAL_HEIGHT_MM - 1) <= ALIKE:
        return ()
    return (
        f"The specimen is {height_mm:g} mm high, tables that come with casr are of {USUAL_HEIGHT_MM:g} mm: on 10 mm "
        "areas and CASR are up to 5 % off at 1.8 to 7.6 N/mm, and more on softer ones. Solve tables (casr dome) and "
        "name them: domes under [runs].",
    )
