"""Stiffness by the pins while a press goes on: presses of known specimens, told once, which each press so far joins.

The press so far is fitted with the sensor as its presses have told it for a prior, from where the fit of the frames
before ended; then the posterior is that of ``casr kappa``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from scipy import special

from casr.camera import Camera
from casr.dome.library import Library
from casr.errors import CasrError
from casr.kappa.discrepancy import Discrepancy
from casr.kappa.estimate import fitted, press_fields, stated_errors
from casr.kappa.family import Family, families
from casr.kappa.known import KnownSensor
from casr.kappa.labels import Labels
from casr.kappa.posterior import Posterior
from casr.kappa.presses import KappaPress
from emg2vsa.arrays import Floats
from emg2vsa.calibration.pinned_presses import camera_of, known_presses, library_of
from emg2vsa.errors import DataError
from emg2vsa.run_scores import RunScores
from emg2vsa.run_scores.domes import Domes
from emg2vsa.settings import CalibrationSettings

NEW = ""
"Name of the specimen that is pressed."
DOUBT_P = 0.01
MUCH_LEFT = 2.0
"Times what presses of the known specimens leave over."


@dataclass(frozen=True, eq=False)
class KnownPins:
    """Presses of known specimens by their pins. camera : of them. tables : digest of those of the domes that explain
    them."""

    sensor: KnownSensor
    camera: Camera
    tables: str

    def posterior(self, settings: CalibrationSettings) -> Posterior:
        """Before the new specimen is pressed. settings : confidence, and how far mountings scatter."""
        return Posterior(self.sensor, _discrepancy(self.sensor, settings), confidence=settings.confidence)

    def family(self, library: Library) -> Family:
        """The domes of these presses. DataError : the tables are others."""
        every = families(library)
        for family in every:
            if family.digest == self.tables:
                return family
        names = ", ".join("".join(family.names) for family in every)
        do = "Give the folder of the tables that it was made with, or write it again with emg2vsa run."
        raise DataError("tables of domes", wanted="those of the calibration", found=f"others, {names}", do=do)


def known_pins(known: Sequence[RunScores], kappa: Floats, kappa_se: Floats, domes: Sequence[Domes]) -> KnownPins | None:
    """What the pins of S known specimens say; None where they tell nothing.

    kappa, kappa_se : (S,) N/mm. known, domes : as for ``design_by_pins``. PassingError : the tables that come with casr
    are damaged.
    """
    try:
        camera = camera_of(known)
        presses = known_presses(known, kappa, kappa_se)
        labels = fitted(presses, camera, families(library_of(camera, domes)), stated_errors(camera))
    except (CasrError, DataError):  # no PassingError, which says nothing of the presses
        return None
    return KnownPins(KnownSensor.of(labels), camera, labels.family.digest)


def _discrepancy(sensor: KnownSensor, settings: CalibrationSettings) -> Discrepancy:
    return sensor.discrepancy.mounted(settings.mounting_sd_percent / 100)


@dataclass(frozen=True)
class ByPins:
    """What a press so far tells. reachable : (low, high) were its label exact. doubt : "" where there is none."""

    low: float
    kappa: float
    high: float
    reachable: tuple[float, float]
    cues: str
    presses: int
    doubt: str


class PinsEstimator:
    """Presses of one new specimen. library : of the tables that the calibration was made with, else DataError.
    settings : confidence, and how far mountings scatter."""

    def __init__(self, pins: KnownPins, library: Library, settings: CalibrationSettings) -> None:
        self._family, self._camera = pins.family(library), pins.camera
        self._usual_px, self._confidence = pins.sensor.misfit_px, settings.confidence
        self._d = _discrepancy(pins.sensor, settings)
        self._before, self._chi2 = pins.sensor, pins.posterior(settings).chi2
        self._known = len(pins.sensor.presses)
        self._now: tuple[KnownSensor, float] | None = None
        self._labels: Labels | None = None
        self._told: ByPins | None = None
        self._mean: Floats | None = None

    def judged(self, press: KappaPress) -> ByPins:
        """Kappa after the press so far, of specimen ``NEW``, with its interval, N/mm. CasrError : its pins tell
        nothing."""
        (field,) = press_fields([press], self._camera, self._family)
        labels = self._before.labelled([field], self._labels)
        if labels is self._labels and self._told:  # no frame that tells more: contacts beyond the tables
            return self._told
        sensor, self._labels = self._before.joined_by(labels), labels
        posterior = Posterior(sensor, self._d, confidence=self._confidence, start=self._mean)
        self._mean = posterior.mean
        best = Posterior(sensor.exact(-1), self._d, confidence=self._confidence, start=posterior.mean)
        self._now = sensor, posterior.chi2
        by_force = sensor.presses[-1].force_variance is not None
        count = len(sensor.presses) - self._known
        low, kappa, high = posterior.interval(NEW)
        self._told = ByPins(
            low, kappa, high, best.interval(NEW)[::2], "pins and force" if by_force else "pins", count,
            self._doubt(labels, posterior.chi2 - self._chi2, (count > 1) + by_force),
        )  # fmt: skip
        return self._told

    def finish(self) -> None:
        """The press is over."""
        if self._now:
            self._before, self._chi2 = self._now
        self._now = self._labels = self._told = self._mean = None

    def _doubt(self, labels: Labels, chi2: float, freedom: int) -> str:
        if labels.misfit_px > MUCH_LEFT * self._usual_px:
            return (
                f"the pins move as on no press of the calibration: {labels.misfit_px:.2g} px are left over, "
                f"{self._usual_px:.2g} px there"
            )
        p = float(special.chdtrc(freedom, max(chi2, 0.0))) if freedom else 1.0
        return f"the press contradicts those of the calibration (p = {p:.2g})" if p < DOUBT_P else ""
