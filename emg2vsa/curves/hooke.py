"""Stiffness from plate indentation, F = kappa (x - x0): Hooke's law for many trials at once (paper IV.B)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from emg2vsa.arrays import Floats, Ints, exponent_of
from emg2vsa.curves.hinge import hinge
from emg2vsa.curves.line import fit_line
from emg2vsa.curves.weighted_rows import weighted_rows


@dataclass(frozen=True)
class HookeFit:
    """d trials; every field (d,), NaN where undefined.

    kappa, kappa_se : force over indentation (N/mm). contact, contact_se : indentation at which the line leaves the
    force of rest, x0. rest : mean force before contact; 0 where contact lies before the first point. r2, adj_r2 : of
    the line, over the points in contact. n_rest, n : points before contact and in contact. dof : n - 2.
    The standard errors take points as independent: filtered samples are not, and then they are too small.
    """

    kappa: Floats
    kappa_se: Floats
    contact: Floats
    contact_se: Floats
    rest: Floats
    r2: Floats
    adj_r2: Floats
    n_rest: Ints
    n: Ints
    dof: Ints

    def notes(self, i: int = 0) -> tuple[str, ...]:
        if np.isnan(self.kappa[i]):
            return (f"undefined: {self.n[i]} points" if self.n[i] < 2 else "undefined: indentation does not change",)
        if not self.kappa[i] > 0:
            return ("force does not rise with indentation: is its sign right?",)
        if self.n_rest[i] == 0:
            return ("no point before contact: contact is where the line meets zero force",)
        return ()


def fit_hooke(indentation: ArrayLike, force: ArrayLike) -> HookeFit:
    """Fit the loading phase of each trial, filtered as the caller wants it (the paper: a five-point moving average).

    indentation : (n,) or (d, n), e.g. mm, into the specimen; force : (n,) or (d, n), e.g. N, compression positive. NaN
    pads short trials; the order of points does not matter. The contact is found: points before it lie about one level,
    those behind it about a line that leaves this level (``hinge``). A specimen that stiffens as it is pressed has no
    single kappa; its line starts late, and adj_r2 tells. DataError where the shapes do not fit.
    """
    rows = weighted_rows(indentation, force, None, where="Hooke fit")
    order = np.argsort(np.where(rows.w > 0, rows.x, np.inf), axis=1, kind="stable")
    x, y, w = (np.take_along_axis(values, order, axis=1) for values in (rows.x, rows.y, rows.w))
    unit_x, unit_y = exponent_of(x), exponent_of(y)
    x, y = np.ldexp(x, -unit_x), np.ldexp(y, -unit_y)
    n_rest = hinge(x, y, rows.n)
    w = np.where(np.arange(x.shape[1]) < n_rest[:, None], 0.0, w)
    resting = np.arange(x.shape[1]) < n_rest[:, None]
    line = fit_line(x, y, w)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        rest = np.where(n_rest > 0, np.sum(y, axis=1, where=resting) / n_rest, 0.0)
        contact = (rest - line.intercept) / line.slope
        # variance of the line at the contact, and of the level before it with the line's residual SD
        middle = np.vecdot(w, x) / np.sum(w, axis=1)
        sxx = np.vecdot(w, (x - middle[:, None]) ** 2)
        at_contact = 1 / line.n + (contact - middle) ** 2 / sxx + np.where(n_rest > 0, 1 / np.maximum(n_rest, 1), 0.0)
        contact_se = line.slope_se * np.sqrt(sxx * at_contact) / np.abs(line.slope)
        unit = (unit_y - unit_x)[:, 0]
        return HookeFit(
            kappa=np.ldexp(line.slope, unit),
            kappa_se=np.ldexp(line.slope_se, unit),
            contact=np.ldexp(contact, unit_x[:, 0]),
            contact_se=np.ldexp(contact_se, unit_x[:, 0]),
            rest=np.ldexp(rest, unit_y[:, 0]),
            r2=line.r2,
            adj_r2=line.adj_r2,
            n_rest=n_rest,
            n=line.n,
            dof=line.dof,
        )
