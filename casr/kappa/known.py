"""A sensor as presses have told it, once and for all: numbers that further presses join with no new fit of the old."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from casr.kappa.discrepancy import USUAL_MISFIT, Discrepancy
from casr.kappa.field import SHARED, PressField
from casr.kappa.forces import forces_of
from casr.kappa.labels import DEPTH_SD_OF_MOUNTING, Labels, labelled

Array = NDArray[np.float64]

CUES = ("pins", "force")
TRAVEL = "travel"
"A cue that some presses have."
_EXACT = 1e10
"Precision of a label that is exact."


@dataclass(frozen=True)
class ToldPress:
    """specimen, mounting, stiffness_n_per_mm, stiffness_sd, travel_mm_per_n : as of ``KappaPress``. force_variance : of
    ln kappa0 by the force of this press; None where it has none."""

    specimen: str
    mounting: str
    stiffness_n_per_mm: float | None
    stiffness_sd: float
    force_variance: float | None
    travel_mm_per_n: float | None = None


@dataclass(frozen=True, eq=False)
class KnownSensor:
    """What P presses in M mountings say.

    mean, precision : (G,), (G, G) of ``SHARED``, the depth of each mounting, z of each press, and ln kappa0 by the
        force of each press that has one; all else that is unknown of a press is left out.
    log_kappa0 : of the dome with the moduli of its tables. misfit_px : root mean square left over, px, noise in it.
    misfit : share of the motion left over beyond noise.
    """

    presses: tuple[ToldPress, ...]
    mountings: tuple[str, ...]
    mean: Array
    precision: Array
    log_kappa0: float
    misfit_px: float
    misfit: float

    @classmethod
    def of(cls, labels: Labels, cues: Sequence[str] = (*CUES, TRAVEL), *, white: bool = False) -> KnownSensor:
        """cues : which are used. white : as if white noise were all that is left over."""
        covariance = np.linalg.inv(labels.white_precision if white else labels.precision)
        if "pins" not in cues:
            covariance[labels.own_at, labels.own_at] += 1.0
        forces = forces_of(labels) if "force" in cues else {}
        first = len(SHARED) + len(labels.mountings)
        every = np.eye(labels.mean.size)
        into = np.vstack([every[:first], every[labels.own_at], *(each.by[None] for each in forces.values())])
        presses = [
            ToldPress(
                press.specimen, press.mounting, press.stiffness_n_per_mm, press.stiffness_sd,
                forces[k].variance if k in forces else None, press.travel_mm_per_n if TRAVEL in cues else None,
            ) for k, press in enumerate(field.press for field in labels.fields)
        ]  # fmt: skip
        return cls(
            tuple(presses), labels.mountings,
            np.concatenate([labels.mean[:first], labels.z, [each.level for each in forces.values()]]),
            _even(np.linalg.inv(into @ covariance @ into.T)),
            labels.family.log_kappa0_at(float(labels.mean[0])), labels.misfit_px, labels.misfit,
        )  # fmt: skip

    @property
    def z_at(self) -> NDArray[np.intp]:
        """(P,) where z of each press stands among the parameters."""
        return len(SHARED) + len(self.mountings) + np.arange(len(self.presses))

    @property
    def with_force(self) -> NDArray[np.intp]:
        """(F,) presses that have forces; theirs are the last parameters, in this order."""
        return np.flatnonzero([press.force_variance is not None for press in self.presses])

    @property
    def with_travel(self) -> NDArray[np.intp]:
        """Rows (K,) of the presses whose travel is known."""
        return np.flatnonzero([press.travel_mm_per_n is not None for press in self.presses])

    @property
    def discrepancy(self) -> Discrepancy:
        """Discrepancy of a sensor that the tables fit as well as this one."""
        return Discrepancy().scaled(max(self.misfit / USUAL_MISFIT, 1.0))

    def prior(self, mountings: Sequence[str]) -> tuple[Array, Array]:
        """Mean (S + M,) and precision (S + M, S + M) of ``SHARED`` and depths of these M mountings, for a press that
        comes."""
        there = [name for name in mountings if name in self.mountings]
        at = self._shared_and(there)
        rows = [*range(len(SHARED)), *(len(SHARED) + mountings.index(name) for name in there)]
        mean, precision = np.zeros(len(SHARED) + len(mountings)), np.eye(len(SHARED) + len(mountings))
        precision /= DEPTH_SD_OF_MOUNTING**2
        mean[rows] = self.mean[at]
        precision[np.ix_(rows, rows)] = np.linalg.inv(np.linalg.inv(self.precision)[np.ix_(at, at)])
        return mean, precision

    def _shared_and(self, mountings: Sequence[str]) -> list[int]:
        return [*range(len(SHARED)), *(len(SHARED) + self.mountings.index(name) for name in mountings)]

    def labelled(self, fields: Sequence[PressField], start: Labels | None = None) -> Labels:
        """Further presses, under the family of this sensor. start : of the same, with fewer frames perhaps."""
        return labelled(fields, self, least_misfit_px=self.misfit_px, start=start)

    def joined_by(self, labels: Labels) -> KnownSensor:
        """The sensor by these presses too, whose prior it was; that must not count twice."""
        new = KnownSensor.of(labels)
        there = [name for name in new.mountings if name in self.mountings]
        mountings = (*self.mountings, *(name for name in new.mountings if name not in there))
        both = replace(self, presses=(*self.presses, *new.presses), mountings=mountings)
        old_z, n_force = len(self.presses), len(self.with_force)
        first_force = int(both.z_at[-1]) + 1
        size = first_force + n_force + len(new.with_force)
        old_at = [*both._shared_and(self.mountings), *both.z_at[:old_z], *range(first_force, first_force + n_force)]
        new_at = [*both._shared_and(new.mountings), *both.z_at[old_z:], *range(first_force + n_force, size)]
        mean, known = self.prior(there)
        precision, pull = np.zeros((size, size)), np.zeros(size)
        for at, own, centre in (
            (old_at, self.precision, self.mean), (new_at, new.precision, new.mean),
            (both._shared_and(there), -known, mean),
        ):  # fmt: skip
            precision[np.ix_(at, at)] += own
            pull[at] += own @ centre
        return replace(both, mean=np.asarray(np.linalg.solve(precision, pull)), precision=_even(precision))

    @property
    def by_shared(self) -> tuple[Array, Array]:
        """(P, S) slopes of the labels over ``SHARED``, and (P,) variance of each about them."""
        covariance, shared = np.linalg.inv(self.precision), len(SHARED)
        rows = covariance[self.z_at]
        slopes = np.linalg.solve(covariance[:shared, :shared], rows[:, :shared].T).T
        own = rows[np.arange(len(rows)), self.z_at] - (slopes * rows[:, :shared]).sum(axis=1)
        return slopes, own

    def exact(self, press: int) -> KnownSensor:
        """Were the label of this press exact: as much as any number of further frames could tell."""
        precision, z = self.precision.copy(), self.z_at[press]
        precision[z, z] += _EXACT
        return replace(self, precision=precision)


def _even(precision: Array) -> Array:
    return np.asarray((precision + precision.T) / 2)
