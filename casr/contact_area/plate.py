"""Whether a sensor is one of the library's: a press on a rigid plate, held against plates only."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from casr.camera import Camera
from casr.contact_area.library_front import library_front
from casr.dome.library import Library
from casr.errors import CameraError

Array = NDArray[np.float64]

LIKE = 0.05
"Misfit up to which areas were 6 to 10 % off at worst; above it, on a wrong dome, 18 to 39 %."
OTHER_LENGTHS_MM = (-0.5, 0.0, 0.5)
"Tried beside the length of the pins that camera.toml states."


@dataclass(frozen=True)
class PlateCheck:
    """A press on a plate.

    dome : of the library that is nearest. misfit : share of the motion that it leaves over. fits : whether that is as
    little as for a sensor of the library. misfit_of_length : the same for lengths of the pins near the stated one, mm.
    """

    dome: str
    misfit: float
    fits: bool
    misfit_of_length: dict[float, float]


def check_on_plate(rest_px: Array, pins_px: Array, camera: Camera, library: Library) -> PlateCheck:
    """Hold a press on a rigid plate against the plates of the library.

    rest_px : (N, 2) pins at rest. pins_px : (T, N, 2) the same pins in contact; NaN where one is lost.
    CameraError : the length of the pins is not known.
    """
    stated_mm = camera.sensor.pin_length_mm
    if stated_mm is None:
        raise CameraError(
            "sensor.pin_length_mm", wanted="the length of the pins", found="none",
            do="Measure it to 0.2 mm and write it under [sensor] in camera.toml: a press does not tell it.",
        )  # fmt: skip
    plates = library.only(np.flatnonzero(np.isinf(library.stiffness_n_per_mm)))
    lengths = [stated_mm + change for change in OTHER_LENGTHS_MM if stated_mm + change > 0]
    fronts = {
        length: library_front(
            rest_px, pins_px, replace(camera, sensor=replace(camera.sensor, pin_length_mm=length)), plates
        )
        for length in lengths
    }
    stated = fronts[stated_mm]
    misfits = {length: front.misfit for length, front in fronts.items()}
    return PlateCheck(stated.dome, stated.misfit, stated.misfit <= LIKE, misfits)
