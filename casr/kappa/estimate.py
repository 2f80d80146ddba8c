"""Kappa of specimens from presses of one sensor: the front door.

found = estimate_kappa(presses, camera)
found.kappas["S2"].value, found.kappas["S2"].low, found.kappas["S2"].high
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from casr.camera import Camera, undistorted
from casr.contact_area.library_front import dome_scale, length_errors
from casr.dome.library import FAMILY, Library, shipped
from casr.dome.view import DomeView
from casr.errors import CameraError, SettingError
from casr.kappa.discrepancy import USUAL_MISFIT, Discrepancy
from casr.kappa.family import Family, families, left_aside
from casr.kappa.field import PressField
from casr.kappa.labels import DEPTH_SD_OF_SENSOR, Labels, SensorErrors, labelled
from casr.kappa.posterior import CONTRADICTED, Kappa, kappas
from casr.kappa.presses import KappaPress
from casr.spread.intervals import CONFIDENCE

USUAL_PIN_MM, UNKNOWN_PIN_SD_MM = 3.0, 1.0
"Pin length, and its standard error, of a sensor whose pin length nobody states."
POLE_SD_MM = 0.15
"Standard error of the dome's axis about the principal point, on the dome of 20 mm."


@dataclass(frozen=True, eq=False)
class SensorKappa:
    """What the presses of a sensor say.

    kappas : by specimen. discrepancy : as it was used. misfit : share of the motion left over beyond noise.
    noise_px : white noise of a pin. notes : what a reader should know.
    """

    kappas: dict[str, Kappa]
    labels: Labels
    discrepancy: Discrepancy
    misfit: float
    noise_px: float
    notes: tuple[str, ...]


def estimate_kappa(
    presses: Sequence[KappaPress],
    camera: Camera,
    *,
    library: Library | None = None,
    discrepancy: Discrepancy | None = None,
    confidence: float = CONFIDENCE,
) -> SensorKappa:
    """Kappa of every specimen among presses of one sensor.

    Specimens of known stiffness calibrate the sensor; without any, the forces and the moduli of the tables' domes do,
    and intervals are wide. library : tables of domes (default: those of casr). confidence : of the intervals.

    CameraError : lengths that cannot be. SettingError : no press, no tables, or two stiffnesses of one specimen.
    PinsError, FramesError : of a press.
    Method and limits: decision 54.
    """
    library = library or shipped()
    labels = fitted(presses, camera, families(library), stated_errors(camera))
    d = (discrepancy or Discrepancy()).scaled(max(labels.misfit / USUAL_MISFIT, 1.0))
    found = kappas(labels, d, confidence)
    return SensorKappa(
        kappas=found, labels=labels, discrepancy=d, misfit=labels.misfit, noise_px=labels.noise_px,
        notes=(*contradictions(found), *of_tables(library), *_notes(labels, camera)),
    )  # fmt: skip


def fitted(
    presses: Sequence[KappaPress], camera: Camera, domes: Sequence[Family], errors: SensorErrors, thorough: bool = False
) -> Labels:
    """All presses under the family that fits them best. thorough : of ``labelled``. Errors as ``estimate_kappa``."""
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
    try:
        tried = [labelled(press_fields(presses, camera, family), errors, thorough=thorough) for family in domes]
    except np.linalg.LinAlgError as error:
        raise CameraError(
            "camera.toml", wanted="depth_mm, fx_px, cx_px and pin_length_mm of the camera that took the frames",
            found="pins that cannot be where they are", do="Measure them, in millimetres and pixels.",
        ) from error  # fmt: skip
    return min(tried, key=lambda each: each.misfit)


def press_fields(presses: Sequence[KappaPress], camera: Camera, family: Family) -> list[PressField]:
    """Presses held against one family. CameraError as ``view_of``; PinsError : of a press."""
    view, unit = view_of(camera), dome_scale(camera) if family.names[0] in FAMILY else 1.0
    return [PressField(_flat(press, camera, unit), view, family) for press in presses]


def stated_errors(
    camera: Camera, *, pole_mm: float = POLE_SD_MM, pin_length_mm: float = 0.1, depth: float = DEPTH_SD_OF_SENSOR
) -> SensorErrors:
    """Those of camera.toml; where it states none, the usual ones given here, mm and relative."""
    scale = dome_scale(camera)
    usual_mm = UNKNOWN_PIN_SD_MM if camera.sensor.pin_length_mm is None else pin_length_mm
    pin_sd_mm, depth_sd = length_errors(camera, usual_mm * scale, depth)
    return SensorErrors(
        pin_length_mm=pin_sd_mm / scale, pole_px=pole_mm * camera.fx_px * scale / camera.depth_mm, depth=depth_sd
    )


def view_of(camera: Camera) -> DomeView:
    """The sensor as it is stated. CameraError : lengths that cannot be."""
    scale, known_mm = dome_scale(camera), camera.sensor.pin_length_mm
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
    return view


def _flat(press: KappaPress, camera: Camera, unit: float) -> KappaPress:
    """Without distortion, and with its force in the unit of the tables: at moduli that stay, kappa0 goes with the size
    of a dome, and the force at an angle with its square; tables of a lab's own have the forces of its sensor."""
    return replace(
        press, rest_px=undistorted(press.rest_px, camera), pins_px=undistorted(press.pins_px, camera),
        force_n=None if press.force_n is None else press.force_n / unit,
    )  # fmt: skip


def contradictions(found: Mapping[str, Kappa], widened: float = 1.0, what: str = "kappa") -> list[str]:
    """widened : by all presses together. what : is not determined then."""
    notes = []
    if (most := max([widened, *(each.contradicted for each in found.values())])) > CONTRADICTED:
        notes.append(
            f"Presses and stated stiffnesses contradict each other {most:.1f} times as much as usual, so {what} is not "
            "determined: check which specimen each press is of, and the stiffness that is stated of each."
        )
    for name, each in found.items():
        if each.known is not None and not each.low <= each.known <= each.high:
            notes.append(
                f"{name} is stated as {each.known:.3g} N/mm, and is {each.value:.3g} [{each.low:.3g}, {each.high:.3g}] "
                "N/mm as the other specimens tell it."
            )
    return notes


def of_tables(library: Library) -> list[str]:
    """A note on domes that are left aside."""
    if not (names := left_aside(library)):
        return []
    return [
        f"Tables of dome {', '.join(names)} are not used: kappa takes a rigid plate and two specimens or more, the "
        "same in both frictions. Solve the tables that are missing with casr dome."
    ]


def _notes(labels: Labels, camera: Camera) -> tuple[str, ...]:
    notes = []
    if camera.sensor.pin_length_mm is None:
        notes.append(
            "Pin length is not known: give pin_length_mm under [sensor] in camera.toml for narrower intervals."
        )
    if labels.misfit > USUAL_MISFIT:
        notes.append(
            f"The pins do not move as on any dome of the tables: {labels.misfit:.0%} of the motion is left over. "
            "Intervals are wider for it; solve tables of this sensor with casr dome."
        )
    known = {f.press.specimen for f in labels.fields if f.press.stiffness_n_per_mm is not None}
    if len(known) < 2:
        notes.append(
            f"{len(known)} specimen of known stiffness: the scale of kappa rests on the moduli of the tables' domes "
            "and on the force. Press two known specimens or more."
        )
    return tuple(notes)
