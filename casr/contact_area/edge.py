"""The contact edge as the fold in the field of pin displacements."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from casr.contact_area.displacement_field import DisplacementField

Array = NDArray[np.float64]

START_PITCHES = (1.2, 1.8, 2.8)
NEXT_SIZES = (0.0, -0.1, 0.1)  # in log size; the best there is may lie beyond the next dent
LOG_SIZE = np.array([0.0, 0.0, 1.0, 0.0, 0.0, 0.0])
ENOUGH_TO_CHOOSE = 1e-2


@dataclass(frozen=True)
class ContactEdge:
    """Elliptic contact edge in the rest frame.

    Parameters
    ----------
    centre_px : (2,) centre.
    a_px, b_px, turn_deg : semi-axis along the direction ``turn_deg`` (from x towards y), and across it.
    stretch : displacement over distance from the centre inside the edge.
    shift_px : (2,) by which all pins moved alike, those at the rim too; the displacement of the centre.
    area_error : relative standard error of the area.
    explained : share of the squared displacement, without the shift, that the model explains.
    parameters : of the fit, to begin another one with.
    """

    centre_px: Array
    a_px: float
    b_px: float
    turn_deg: float
    stretch: float
    shift_px: Array
    area_error: float
    explained: float
    parameters: Array


def fit_edge(rest_px: Array, displacement_px: Array, pitch_px: float, near: ContactEdge | None = None) -> ContactEdge:
    """Least-squares edge of the contact.

    The displacement is a common shift, a bending and a stretching of the skin around an ellipse (see
    displacement_field.py), none of the two negative. Those strengths are linear and eliminated. Left are six
    parameters, by Levenberg-Marquardt: centre, size and ellipse of the contact, and the radius of the rim that holds
    the skin; the rim lies around the middle of the pins, and the search begins with one row beyond the outermost.
    Several sizes start, and the best is tried on both sides, as the cost has a dent wherever the edge crosses a pin.

    Parameters
    ----------
    rest_px, displacement_px : (N, 2) of all pins, moved or not.
    pitch_px : pin pitch.
    near : edge of a frame close by, to begin with instead of several sizes.
    """
    rest, displacement = (points[:, 0] + 1j * points[:, 1] for points in (rest_px, displacement_px))
    middle = rest.mean()
    rim = np.log(np.abs(rest - middle).max() + pitch_px)
    moved = np.abs(displacement) ** 3
    centre = moved @ rest / moved.sum() if moved.any() else middle
    field = DisplacementField(rest, displacement, middle, np.ones(rest.size))
    if near is None:
        starts = [np.array([centre.real, centre.imag, np.log(n * pitch_px), 0.0, 0.0, rim]) for n in START_PITCHES]
    else:
        starts = [near.parameters]
    best = field.lowest(starts, ENOUGH_TO_CHOOSE)
    for sizes in (NEXT_SIZES, (0.0,)):
        field = field.trusting(best)
        best = field.lowest([best + size * LOG_SIZE for size in sizes])
    return _edge(field, best)


def _edge(field: DisplacementField, p: Array) -> ContactEdge:
    strengths, shift = field.strengths(p)
    size, oblong = float(np.exp(p[2])), float(np.hypot(p[3], p[4]))
    return ContactEdge(
        centre_px=p[:2],
        a_px=size * float(np.exp(-oblong)),
        b_px=size * float(np.exp(oblong)),
        turn_deg=float(np.rad2deg(np.arctan2(p[4], p[3]) / 2)),
        stretch=float(strengths.sum()),
        shift_px=np.array([shift.real, shift.imag]),
        area_error=2 * float(field.standard_errors(p)[2]),
        explained=field.explained(p),
        parameters=p,
    )
