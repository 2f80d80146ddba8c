"""Kappa of specimens from presses of one sensor: the front door.

found = estimate_kappa(presses, camera)
found.kappas["S2"].value, found.kappas["S2"].low, found.kappas["S2"].high
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from casr.camera import Camera, undistorted
from casr.contact_area.library_front import dome_scale
from casr.dome.library import Library, shipped
from casr.dome.view import DomeView
from casr.errors import CameraError, SettingError
from casr.kappa.family import families
from casr.kappa.field import PressField
from casr.kappa.labels import Labels, SensorErrors, labelled
from casr.kappa.posterior import Discrepancy, Kappa, kappas
from casr.kappa.presses import KappaPress

USUAL_PIN_MM, UNKNOWN_PIN_SD_MM = 3.0, 1.0
"Of a sensor whose pin length nobody states."
POLE_SD_MM = 0.15
"Of the dome's axis from the principal point, on the dome of 20 mm."
USUAL_MISFIT = 0.02
"Share of the motion left over beyond noise; where there is more, the tables fit this sensor less well than each other."


@dataclass(frozen=True, eq=False)
class SensorKappa:
    """What the presses of a sensor say.

    kappas : by specimen. dome_place : of the dome in its family, 0 the softest filling.
    pin_length_mm, depth_mm : of the sensor as fitted. misfit : share of the motion left over beyond noise.
    noise_px : white noise of a pin. notes : what a reader should know.
    """

    kappas: dict[str, Kappa]
    labels: Labels
    dome_place: float
    pin_length_mm: float
    depth_mm: float
    misfit: float
    noise_px: float
    notes: tuple[str, ...]


def estimate_kappa(
    presses: Sequence[KappaPress],
    camera: Camera,
    *,
    library: Library | None = None,
    errors: SensorErrors | None = None,
    discrepancy: Discrepancy | None = None,
) -> SensorKappa:
    """Kappa of every specimen among presses of one sensor.

    Specimens of known stiffness calibrate the sensor; without any, the forces and the moduli of the tables' domes do,
    and intervals are wide. library : tables of domes (default: those of casr).

    CameraError : lengths that cannot be. SettingError : no press, no tables, or two stiffnesses of one specimen.
    PinsError, FramesError : of a press.
    """
    if not presses:
        raise SettingError("presses", wanted="one press or more", found="none", do="Give presses of one sensor.")
    stated: dict[str, float | None] = {}
    for press in presses:
        known = press.stiffness_n_per_mm
        if stated.setdefault(press.specimen, known) != known:
            raise SettingError(
                f"specimen {press.specimen}, stiffness_n_per_mm", wanted="one stiffness, or none, for all its presses",
                found=f"{stated[press.specimen]} and {known}", do="Give another specimen another name.",
            )  # fmt: skip
    scale = dome_scale(camera)
    view, sensor_errors = _view(camera, scale)
    flat = [_undistorted(press, camera) for press in presses]
    tried = [
        labelled([PressField(press, view, family) for press in flat], family, errors or sensor_errors)
        for family in families(library or shipped())
    ]
    labels = min(tried, key=lambda each: each.misfit_px)
    moved_px = labels.misfit_px / labels.misfit_share
    misfit = float(np.sqrt(max(labels.misfit_px**2 - labels.noise_px**2, 0.0))) / moved_px
    d = (discrepancy or Discrepancy()).scaled(max(misfit / USUAL_MISFIT, 1.0))
    place, pin_mm, log_depth = labels.mean[:3]
    return SensorKappa(
        kappas=kappas(labels, d), labels=labels, dome_place=float(place),
        pin_length_mm=float(view.pin_length_mm + pin_mm) * scale, depth_mm=float(camera.depth_mm * np.exp(log_depth)),
        misfit=misfit, noise_px=labels.noise_px, notes=_notes(labels, camera, misfit),
    )  # fmt: skip


def _view(camera: Camera, scale: float) -> tuple[DomeView, SensorErrors]:
    known_mm = camera.sensor.pin_length_mm
    pin_mm = USUAL_PIN_MM if known_mm is None else known_mm / scale
    view = DomeView(
        focal_px=(camera.fx_px, camera.fy_px), pole_px=(camera.cx_px, camera.cy_px), depth_mm=camera.depth_mm / scale,
        pin_length_mm=pin_mm,
    )  # fmt: skip
    if view.behind_mm <= 0 or view.tip_radius_mm <= 0:
        raise CameraError(
            "camera.depth_mm, sensor.pin_length_mm", wanted="a camera behind the dome's centre, and short pins",
            found=f"{camera.depth_mm:g} mm and {pin_mm * scale:g} mm", do="Measure both, in millimetres.",
        )  # fmt: skip
    errors = SensorErrors(pole_px=POLE_SD_MM * camera.fx_px / view.depth_mm)
    if (depth_sd_mm := camera.depth_sd_mm) is not None:
        errors = replace(errors, depth=depth_sd_mm / camera.depth_mm)
    pin_sd_mm = UNKNOWN_PIN_SD_MM if known_mm is None else camera.sensor.pin_length_sd_mm
    return view, errors if pin_sd_mm is None else replace(errors, pin_length_mm=pin_sd_mm / scale)


def _undistorted(press: KappaPress, camera: Camera) -> KappaPress:
    if not camera.distortion:
        return press
    return replace(
        press, rest_px=undistorted(press.rest_px, camera), pins_px=undistorted(press.pins_px, camera)
    )  # fmt: skip


def _notes(labels: Labels, camera: Camera, misfit: float) -> tuple[str, ...]:
    notes = []
    if camera.sensor.pin_length_mm is None:
        notes.append(
            "Pin length is not known: give pin_length_mm under [sensor] in camera.toml for narrower intervals."
        )
    if misfit > USUAL_MISFIT:
        notes.append(
            f"The pins do not move as on any dome of the tables: {misfit:.0%} of the motion is left over. Intervals "
            "are wider for it; solve tables of this sensor with casr dome."
        )
    known = {f.press.specimen for f in labels.fields if f.press.stiffness_n_per_mm is not None}
    if len(known) < 2:
        notes.append(
            f"{len(known)} specimen of known stiffness: the scale of kappa rests on the moduli of the tables' domes "
            "and on the force. Press two known specimens or more."
        )
    return tuple(notes)
