"""A sensor from presses of known specimens: pole, pin length, depth and moduli of its dome, with standard errors.

All presses are fitted as for kappa (``casr.kappa.labels``), from several places of the family and with wide errors of
what camera.toml states; what is found is the posterior given the known specimens (``casr.kappa.posterior``).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from casr.camera import Camera
from casr.contact_area.library_front import dome_scale
from casr.dome.library import FAMILY, MODULI_MPA, Library, shipped
from casr.dome.view import INNER_RADIUS_MM, OUTER_RADIUS_MM, SKIN_MM
from casr.errors import SettingError
from casr.kappa.discrepancy import USUAL_MISFIT, Discrepancy
from casr.kappa.estimate import contradictions, fitted, of_tables, stated_errors, view_of
from casr.kappa.family import Family, families
from casr.kappa.known import KnownSensor
from casr.kappa.labels import PLACE_SD, Labels, SensorErrors
from casr.kappa.posterior import CONTRADICTED, Posterior, kappas
from casr.kappa.presses import KappaPress

Array = NDArray[np.float64]

POLE_SD_MM, PIN_LENGTH_SD_MM, DEPTH_SD = 2.0, 0.4, 0.03
"Standard errors of values of camera.toml that states none: those of a sensor that nobody measured with care."
TOLD = 0.7
"Presses tell what they leave a smaller share of its error before them."
NOMINAL = SensorErrors(pin_length_mm=1e-6, pole_px=1e-6, depth=1e-6)
QUANTITIES = (
    "pole_x_px", "pole_y_px", "pin_length_mm", "depth_mm", "gel_over_skin", "skin_modulus_mpa", "gel_modulus_mpa",
)  # fmt: skip
OFF_FAMILY = np.array([0.02, 0.02, 0.035, 0.005, 0.07, 0.03, 0.03])
"""Standard deviations by which presses of a dome that the tables do not hold are taken for those of another sensor, by
``QUANTITIES``: mm, then relative. Found by leaving out one dome at a time (benchmarks/sensor.py, seeds 0 to 7)."""
OFF_THICKNESS = np.array([0.1, 0.1, 0.4, 0.05, 0.6, 0.4, 0.4])
"""The same of a dome that differs in more than its moduli: a skin of 1.5 mm leaves 2 to 3 % over by tables of 1 mm.
It grows with what is left over beyond ``FAMILY_MISFIT``, and is whole at ``USUAL_MISFIT``."""
FAMILY_MISFIT = 0.01
_STEP = 1e-3


@dataclass(frozen=True)
class Quantity:
    """One quantity of a sensor. stated : in camera.toml; None of what it does not hold. sd, prior_sd : standard errors
    of the value with the presses, and before them. told : whether the presses say more of it than was known before.
    """

    value: float
    sd: float
    prior_sd: float
    stated: float | None
    told: bool


@dataclass(frozen=True, eq=False)
class IdentifiedSensor:
    """A sensor as its presses tell it.

    camera : with pole, depth, pin length and their errors. quantities : by the names of ``QUANTITIES``.
    skin_mm : of the tables that fit best, not measured. dome : of these tables.
    misfit_before : share of the motion left over beyond noise by the best dome that comes with casr under the camera as
    stated; misfit : as identified. fits : whether the tables do, by that. contradicted : by how much
    presses and stated stiffnesses contradict each other, as of ``Kappa``; above ``CONTRADICTED`` nothing is told.
    notes : what a reader should know.
    """

    camera: Camera
    quantities: Mapping[str, Quantity]
    skin_mm: float
    dome: str
    misfit_before: float
    misfit: float
    fits: bool
    contradicted: float
    notes: tuple[str, ...]

    def to_toml(self) -> str:
        """A camera.toml, and where moduli of the tables are known also a file for ``casr dome``."""
        if "skin_modulus_mpa" not in self.quantities:
            return self.camera.to_toml()
        skin, gel = self.quantities["skin_modulus_mpa"], self.quantities["gel_modulus_mpa"]
        radius_mm = (self.camera.sensor.dome_radius_mm or OUTER_RADIUS_MM) * INNER_RADIUS_MM / OUTER_RADIUS_MM
        return f"""{self.camera.to_toml()}
[dome]
name = "identified"
radius_mm = {radius_mm + self.skin_mm:.4g}
skin_mm = {self.skin_mm:.4g}  # of the tables that fit best, not measured
skin_modulus_mpa = {skin.value:.3g}  # standard error {skin.sd:.1g}
gel_modulus_mpa = {gel.value:.3g}  # standard error {gel.sd:.1g}
"""


def identify_sensor(
    presses: Sequence[KappaPress],
    camera: Camera,
    *,
    library: Library | None = None,
    own_domes: Mapping[str, tuple[float, float, float]] | None = None,
) -> IdentifiedSensor:
    """Identify a sensor from presses of specimens of known stiffness, or of a rigid plate.

    camera : as it is thought to be. library : tables of domes (default: those of casr). own_domes : thickness of the
    skin, mm, and moduli of skin and gel, MPa, of domes that do not come with casr. Errors as ``estimate_kappa``;
    SettingError : no known specimen.
    Method and limits: decision 55.
    """
    if presses and all(press.stiffness_n_per_mm is None for press in presses):
        raise SettingError(
            "specimens, stiffness_n_per_mm", wanted="a known specimen, or a rigid plate", found="none",
            do="Press a specimen whose stiffness is measured, or a plate: its stiffness is rigid.",
        )  # fmt: skip
    library, scale = library or shipped(), dome_scale(camera)
    errors = stated_errors(camera, pole_mm=POLE_SD_MM, pin_length_mm=PIN_LENGTH_SD_MM, depth=DEPTH_SD)
    labels = fitted(presses, camera, families(library), errors, thorough=True)
    ours = [Family(library, (dome,)) for dome in FAMILY if dome in library.dome]
    before = fitted(presses, camera, ours or [labels.family], NOMINAL).misfit
    known = KnownSensor.of(labels)
    posterior = Posterior(known, known.discrepancy)
    family, place = labels.family, float(posterior.mean[0])
    domes = {dome: (SKIN_MM * scale, *moduli) for dome, moduli in MODULI_MPA.items()} | dict(own_domes or {})
    of_others = kappas(labels, known.discrepancy)
    contradicted = max([posterior.widened, *(each.contradicted for each in of_others.values())])
    solved = np.array([domes.get(dome, (np.nan,) * 3) for dome in family.names])
    quantities = _quantities(posterior, family, camera, errors, np.log(solved[:, 1:]), labels.misfit)
    if contradicted > CONTRADICTED:
        quantities = {name: replace(each, told=False) for name, each in quantities.items()}
    identified = IdentifiedSensor(
        camera=_camera(camera, quantities), quantities=quantities, skin_mm=family.at(place, solved[:, 0]),
        dome=_dome(family, place), misfit_before=before, misfit=labels.misfit,
        fits=bool(labels.misfit <= USUAL_MISFIT and 0 <= place <= 1), contradicted=contradicted,
        notes=tuple(contradictions(of_others, posterior.widened, "the sensor")),
    )  # fmt: skip
    return replace(identified, notes=(*identified.notes, *of_tables(library), *_notes(identified, labels)))


def _quantities(
    posterior: Posterior, family: Family, camera: Camera, errors: SensorErrors, log_moduli: Array, misfit: float
) -> dict[str, Quantity]:
    """log_moduli : (D, 2) ln of those of skin and gel, MPa, of the family's domes; NaN where they are not known."""
    n, scale, at, view = posterior.n_label, dome_scale(camera), posterior.mean, view_of(camera)
    log_skin, log_ratio = log_moduli[:, 0], log_moduli[:, 1] - log_moduli[:, 0]
    unit = np.log(scale) if family.names[0] in FAMILY else 0.0

    def moduli(place: float) -> Array:
        """ln of gel over skin, of skin and of gel."""
        ratio, skin = family.at(place, log_ratio), at[n] - family.at(place, family.log_kappa0 - log_skin) - unit
        return np.array([ratio, skin, skin + ratio])

    by = np.zeros((len(QUANTITIES), n + 1))
    by[[0, 1, 2, 3, 5, 6], [3, 4, 1, 2, n, n]] = 1, 1, scale, 1, 1, 1
    by[4:, 0] = (moduli(at[0] + _STEP) - moduli(at[0] - _STEP)) / (2 * _STEP)
    px_per_mm, free = camera.fx_px / view.depth_mm, Discrepancy.log_kappa0
    of_place = max(PLACE_SD * abs(by[4, 0]), OFF_FAMILY[4])
    prior_sd = np.array([*[errors.pole_px] * 2, errors.pin_length_mm * scale, errors.depth, of_place, free, free])
    worse = max(misfit - FAMILY_MISFIT, 0.0) / (USUAL_MISFIT - FAMILY_MISFIT)
    beyond = np.hypot(OFF_FAMILY, worse * OFF_THICKNESS) * [px_per_mm, px_per_mm, scale, 1, 1, 1, 1]
    variance = np.diag(by @ posterior.covariance[: n + 1, : n + 1] @ by.T) * posterior.widened**2
    sd = np.minimum(np.sqrt(variance + beyond**2), prior_sd)
    pin_mm, log_depth = (view.pin_length_mm + at[1]) * scale, np.log(camera.depth_mm) + at[2]
    value = np.array([*(at[3:5] + view.pole_px), pin_mm, *np.exp([log_depth, *moduli(at[0])])])
    unit_of = np.append(np.ones(3), value[3:])  # of the logarithms
    stated = (camera.cx_px, camera.cy_px, camera.sensor.pin_length_mm, camera.depth_mm, None, None, None)
    numbers = (
        value.tolist(),
        (sd * unit_of).tolist(),
        (prior_sd * unit_of).tolist(),
        stated,
        (sd < TOLD * prior_sd).tolist(),
    )
    each = zip(QUANTITIES, map(Quantity, *numbers), strict=True)
    return {name: quantity for name, quantity in each if np.isfinite(quantity.value)}


def _camera(camera: Camera, found: Mapping[str, Quantity]) -> Camera:
    """A lens that was calibrated has its principal point already; a pole beside it is not the camera's."""
    value = {name: float(f"{each.value:.6g}") for name, each in found.items()}
    sd = {name: float(f"{each.sd:.2g}") for name, each in found.items()}
    sensor = replace(camera.sensor, pin_length_mm=value["pin_length_mm"], pin_length_sd_mm=sd["pin_length_mm"])
    camera = replace(camera, depth_mm=value["depth_mm"], depth_sd_mm=sd["depth_mm"], sensor=sensor)
    return camera if camera.distortion else replace(camera, cx_px=value["pole_x_px"], cy_px=value["pole_y_px"])


def _dome(family: Family, place: float) -> str:
    row = int(np.clip(np.searchsorted(family.place, place), 1, max(len(family.names) - 1, 1)))
    return " and ".join(family.names[row - 1 : row + 1])


def _notes(found: IdentifiedSensor, labels: Labels) -> tuple[str, ...]:
    notes = []
    blind = [name for name, each in found.quantities.items() if not each.told]
    if blind and found.contradicted <= CONTRADICTED:
        notes.append(
            f"These presses do not tell {', '.join(blind)}: what is known of it is about what was known before. Press "
            "more known specimens, soft and stiff, and state pin_length_sd_mm and depth_sd_mm of what you measured."
        )
    if not found.fits:
        notes.append(
            f"{found.misfit:.0%} of the motion is left over, or the dome lies outside the tables: they are not of this "
            "sensor. Solve tables of it, casr dome FILE --out mine, with the file that this command wrote (measure "
            "skin_mm), then casr sensor once more with --domes mine."
        )
    if not any(np.isfinite(f.press.stiffness_n_per_mm or np.inf) for f in labels.fields):
        notes.append("On a rigid plate alone moduli rest on the force: a soft known specimen tells them apart from it.")
    if found.camera.distortion:
        notes.append(
            "cx_px and cy_px stay, which belong to the lens; the pole is where the dome's axis meets the image."
        )
    return tuple(notes)
