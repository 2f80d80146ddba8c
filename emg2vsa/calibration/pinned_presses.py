"""Presses of runs as ``casr.kappa`` takes them: their pins, the camera that saw them, the tables of their domes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from casr.camera import Camera, Sensor
from casr.contact_area.library_front import height_in_tables
from casr.dome.library import Library, tables
from casr.dome.tables import USUAL_HEIGHT_MM
from casr.kappa.presses import KappaPress
from emg2vsa.arrays import Floats
from emg2vsa.errors import DataError
from emg2vsa.run_scores import RunScores
from emg2vsa.run_scores.domes import ALIKE, Domes


def camera_of(runs: Sequence[RunScores]) -> Camera:
    """DataError : a run has none, or another than the first."""
    cameras = {run: Camera(**{**run.camera, "sensor": Sensor(**run.camera["sensor"])}) for run in runs if run.camera}
    first = cameras.get(runs[0])
    other = next((run for run in runs if first is None or not first.sees_like(cameras.get(run))), None)
    if first is None or other:
        found = "another" if other in cameras else "none, or more than one"
        raise DataError(
            f"{(other or runs[0]).name}, camera.toml", wanted=f"one camera of all presses, as of {runs[0].name}",
            found=found, do="Give all runs the camera.toml of the camera that took their frames.",
        )  # fmt: skip
    return first


def library_of(camera: Camera, domes: Sequence[Domes]) -> Library:
    """Tables of specimens of one height, the usual one where none is stated of some. DataError : of several."""
    stated = [each.specimen_height_mm for each in domes]
    heights = [each or USUAL_HEIGHT_MM for each in stated] if any(stated) else []
    if heights and max(heights) > (1 + ALIKE) * min(heights):
        usual = "" if all(stated) else f" ({USUAL_HEIGHT_MM:g} mm where none is stated)"
        raise DataError(
            "height_mm, new_height_mm", wanted="specimens of one height",
            found=f"{min(heights):g} to {max(heights):g} mm{usual}",
            do="State the height of every specimen, and press those of one height, or take kappa by CASR.",
        )  # fmt: skip
    folder = domes[0].domes
    if folder is None and heights and abs(heights[0] / USUAL_HEIGHT_MM - 1) > ALIKE:
        # on specimens of 10 mm kappa by these tables is 15 % low, and 6 of 16 intervals hold it (benchmark own_kappa)
        raise DataError(
            "height_mm", wanted=f"specimens of {USUAL_HEIGHT_MM:g} mm, or tables of their height",
            found=f"{heights[0]:g} mm", do="Solve tables (casr dome) and name them: domes under [runs].",
        )  # fmt: skip
    return tables(folder, height_in_tables(camera, folder, heights[0] if folder and heights else None))


def known_presses(known: Sequence[RunScores], kappa: Floats, kappa_se: Floats) -> list[KappaPress]:
    """Presses of S specimens with their stiffness and its standard error, (S,) N/mm; none of one whose pins could not
    be followed."""
    stated = zip(known, kappa.tolist(), kappa_se.tolist(), strict=True)
    return [press for run, value, error in stated if any(run.pins) for press in presses_of(run, value, error / value)]


def presses_of(run: RunScores, known: float | None, sd: float) -> list[KappaPress]:
    """Those whose pins were followed. DataError : none."""
    found = [
        KappaPress(
            rest_px=pins.rest_px, pins_px=np.asarray(pins.pins_px, np.float64), force_n=pins.force_n,
            force_zero_sd_n=pins.force_zero_sd_n, specimen=run.specimen, mounting=f"{run.specimen} {mounting}",
            stiffness_n_per_mm=known, stiffness_sd=sd, name=f"{run.name}, press {repetition}",
            travel_mm_per_n=1 / slope if slope > 0 else None,
        )
        for pins, mounting, repetition, slope in zip(
            run.pins, run.mounting.tolist(), run.repetitions.tolist(), run.indent_n_per_mm.tolist(), strict=True
        )
        if pins is not None
    ]  # fmt: skip
    if not found:
        raise DataError(run.name, wanted="presses whose pins can be followed", found="none", do="Look at the frames.")
    return found
