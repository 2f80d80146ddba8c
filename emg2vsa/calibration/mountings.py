"""How much a score differs from one mounting of a specimen to the next: a random effect that ten presses do not show.

A score is its specimen's x (1 + mounting + press). The presses of one mounting share its part: depth of the camera,
place and thickness of the specimen, delay of the camera, angle. Where specimens were mounted several times, the scatter
of the means of their mountings tells its variance (analysis of variance of unweighted means, shares of the specimen's
score, pooled over specimens):

    t^2 = max(v - c s^2, 0),  v = sum (mean_m - mean)^2 / f,  f = sum over specimens of (mountings - 1),

with the variance s^2 of a press within its mounting, and c the mean of 1 / presses of a mounting. Where no mounting
was pressed twice, s^2 counts as 0 and t^2 is the whole scatter. Where f is below
``LEAST_FREEDOM`` the SD is assumed (``[calibration] mounting_sd_percent``), and counts as if it were known.

A study mounts its specimens anew for every angle and condition, so that all of them tell it together (``pooled``). One
whose mountings scatter more than those of the others counts for itself.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import special

from emg2vsa.arrays import Floats, Ints, mean_of
from emg2vsa.calibration.presses import within

LEAST_FREEDOM = 3
"Between mountings: two mountings of each of three specimens. With fewer the SD is assumed."
ENOUGH_FREEDOM = 30
"Between mountings: their SD is then known to 13 %, so that a design that is judged by it was not picked by chance."
_UNLIKE_P = 0.05


@dataclass(frozen=True, eq=False)
class MountingScatter:
    """Scatter of mountings in d calibrations; (d,), shares of a score.

    sd : t, from one mounting to the next. freedom : f, 0 where the SD is assumed. between : v. of_presses : c s^2.
    assumed : the SD of a mounting that the study assumes.
    """

    sd: Floats
    freedom: Floats
    between: Floats
    of_presses: Floats
    assumed: Floats

    def as_assumed(self) -> MountingScatter:
        """The SD that the study assumes, where so few mountings were repeated that chance decides theirs."""
        found = (self.assumed == 0) | (self.freedom >= ENOUGH_FREEDOM)
        freedom, between, of_presses = (
            np.where(found, each, 0.0) for each in (self.freedom, self.between, self.of_presses)
        )
        return MountingScatter(np.where(found, self.sd, self.assumed), freedom, between, of_presses, self.assumed)


def mounting_scatter(scores: Floats, labels: Ints, assumed_sd: float) -> MountingScatter:
    """Scatter of mountings of presses (d, S, R) with the number of their mounting (S, R)."""
    groups = by_mounting(scores, labels)
    with np.errstate(invalid="ignore", divide="ignore"):
        groups = groups / mean_of(scores)[:, :, None, None]
        variance, n = within(groups)
        means = mean_of(groups)
        spread, mountings = within(means)
        f = np.maximum(mountings - 1, 0)
        freedom = f.sum(axis=1).astype(np.float64)
        between = np.sum(np.where(f > 0, f * spread, 0.0), axis=1) / freedom
        inside = np.maximum(n - 1, 0)
        # one press of each mounting: the scatter of the mountings is all there is, with that of the presses in it
        pressed_again = np.maximum(inside.sum(axis=(1, 2)), 1)
        press = np.nansum(inside * np.where(inside > 0, variance, 0.0), axis=(1, 2)) / pressed_again
        shares = np.sum(np.where(n > 0, 1 / n, 0.0), axis=2) / mountings
        of_presses = press * np.sum(np.where(f > 0, f * shares, 0.0), axis=1) / freedom
    return _told(freedom, between, of_presses, np.full(freedom.shape, assumed_sd, dtype=np.float64))


def pooled(designs: MountingScatter) -> MountingScatter:
    """Pooled scatter of all d designs of a study; of one alone whose mountings scatter more than the others' (F test at
    5 %), and of each alone where only some pressed a mounting twice."""
    f, there = designs.freedom, designs.freedom > 0
    if np.unique(designs.of_presses[there] > 0).size != 1:
        return designs
    total, between, of_presses = (float(np.sum(f * each)) for each in (there, designs.between, designs.of_presses))
    with np.errstate(invalid="ignore", divide="ignore"):
        others = (between - f * designs.between) / (total - f)
        more = there & (special.fdtrc(f, total - f, designs.between / others) < _UNLIKE_P)
    return _told(
        np.where(more, f, total),
        np.where(more, designs.between, between / total),
        np.where(more, designs.of_presses, of_presses / total),
        designs.assumed,
    )


def _told(freedom: Floats, between: Floats, of_presses: Floats, assumed: Floats) -> MountingScatter:
    """Assumed where the freedom is too small."""
    told = (freedom >= LEAST_FREEDOM) & np.isfinite(between + of_presses)
    estimate = np.sqrt(np.maximum(np.where(told, between - of_presses, 0.0), 0.0))
    freedom, between, of_presses = (np.where(told, each, 0.0) for each in (freedom, between, of_presses))
    return MountingScatter(np.where(told, estimate, assumed), freedom, between, of_presses, assumed)


def by_mounting(scores: Floats, labels: Ints) -> Floats:
    """(d, S, M, R) the presses (d, S, R) of each mounting, NaN elsewhere; labels : (S, R)."""
    same = labels[:, None, :] == np.unique(labels)[:, None]
    return np.where(same, scores[:, :, None, :], np.nan)


def share_of_mountings(groups: Floats) -> Floats:
    """(d, S) by which the variance between mountings enters the mean of all presses: 1 / M where they share alike."""
    n = np.count_nonzero(np.isfinite(groups), axis=-1)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray(np.nan_to_num(np.sum(n**2, axis=-1) / np.sum(n, axis=-1) ** 2))
