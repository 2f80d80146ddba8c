"""The front door of the contact front: which of its two models a press is told by."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from casr.camera import Camera
from casr.contact_area.analytic_front import analytic_front
from casr.contact_area.front import ContactFront
from casr.contact_area.front_fit import FrontFit
from casr.contact_area.library_front import library_fits, library_front
from casr.dome.library import Library
from casr.errors import PinsError

Array = NDArray[np.float64]

FEWEST_PINS, FEWEST_FRAMES = 7, 2
ELSEWHERE = 0.06
"Misfit of the library from which on the analytic field is fitted, too."
FAR_BETTER = 0.5
"Alone it is taken where its misfit is less than this share of the library's; else both count."
MAY_FIND, MUST_FIND = 1.3, 4.0
"""Times the frames from which centre and worlds were found last, from which on they are found again. After twice the
frames areas by those found anew differ by 0.05 %."""
EXPLAINED, MOST_SHARE = 0.05, 0.5
"Misfit of the analytic field from which on so much of its distance to the library's areas is a standard error."


def contact_front(
    rest_px: Array,
    pins_px: Array,
    camera: Camera | None,
    library: Library,
    fits: Sequence[FrontFit] | None = None,
) -> ContactFront:
    """The contact in T frames: by the library of finite-element domes, analytically where that explains far more, or by
    both.

    Parameters
    ----------
    rest_px : (N, 2) pins at rest. pins_px : (T, N, 2) the same pins in contact; NaN where one is lost.
    camera : None leaves areas in px^2, and the size of the dome unknown.
    fits : of ``library_fits`` for these frames; None finds them.

    Raises
    ------
    PinsError : fewer than seven pins in some frame, or fewer than two frames. CameraError : pins longer than can be.
    """
    rest_px, pins_px = np.asarray(rest_px, dtype=np.float64), np.asarray(pins_px, dtype=np.float64)
    fewest = int(np.isfinite(pins_px[..., 0]).sum(axis=1).min(initial=len(rest_px)))
    if fewest < FEWEST_PINS or len(pins_px) < FEWEST_FRAMES:
        raise PinsError(
            "contact front",
            wanted=f"{FEWEST_PINS} pins in every frame, and {FEWEST_FRAMES} frames",
            found=f"{fewest} pins, {len(pins_px)} frames",
            do="Leave out the frames without pins.",
        )
    front = library_front(rest_px, pins_px, camera, library, fits)
    if front.misfit > ELSEWHERE:
        other = analytic_front(rest_px, pins_px, camera)
        front = _analytic(other, front) if other.misfit < FAR_BETTER * front.misfit else _both(front, other)
    return front.with_note_on_size()


class FrontSoFar:
    """The contact front of a press that goes on: centre and worlds are found now and then, and kept between.

    Parameters
    ----------
    camera, library : of ``contact_front``.
    """

    def __init__(self, camera: Camera | None, library: Library) -> None:
        self._camera, self._library = camera, library
        self._fits: list[FrontFit] | None = None
        self._found_in = 0
        self.front: ContactFront | None = None
        "Of the last frames."

    def of(self, rest_px: Array, pins_px: Array) -> ContactFront:
        """The contact in the T frames so far; arguments and errors of ``contact_front``."""
        if self._fits is None or len(pins_px) >= MUST_FIND * self._found_in:
            self._find(rest_px, pins_px, looks=2)
        elif len(pins_px) >= FEWEST_FRAMES:
            self._fits = library_fits(rest_px, pins_px, self._camera, self._library, like=self._fits)
        self.front = contact_front(rest_px, pins_px, self._camera, self._library, self._fits)
        return self.front

    def settle(self, rest_px: Array, pins_px: Array) -> None:
        """Find centre and worlds again if there are many more frames than when they were found: work for the time in
        which no frame waits."""
        if len(pins_px) >= max(MAY_FIND * self._found_in, FEWEST_FRAMES):
            self._find(rest_px, pins_px, looks=1)

    def _find(self, rest_px: Array, pins_px: Array, looks: int) -> None:
        self._fits = library_fits(rest_px, pins_px, self._camera, self._library, near=self._fits, looks=looks)
        self._found_in = len(pins_px)


def _analytic(analytic: ContactFront, library: ContactFront) -> ContactFront:
    """The analytic model's areas; the less it explains, the more of their distance to the library's is in the error."""
    share = MOST_SHARE * min(analytic.misfit / EXPLAINED, 1.0)
    parts = dict(analytic.parts)
    parts["dome"] = np.hypot(parts["dome"], share * np.abs(np.log(analytic.area / library.area)))
    return replace(
        analytic,
        candidates=np.stack([analytic.area, library.area]),
        weight=np.array([1.0, 0.0]),
        spread_weight=np.array([1 - share**2, share**2]),
        parts=parts,
        off_library=library.misfit,
        notes=(_said(analytic, library),),
    )


def _both(library: ContactFront, analytic: ContactFront) -> ContactFront:
    """The mean of the logarithms by the two models, weighted by their misfits; half their distance is in the error."""
    votes = 1 / np.array([library.misfit, analytic.misfit]) ** 2
    of_library, of_analytic = votes / votes.sum()
    logs = np.log(library.area), np.log(analytic.area)
    parts = dict(library.parts)
    parts["dome"] = np.hypot(parts["dome"], np.abs(logs[0] - logs[1]) / 2)
    return replace(
        library,
        area=np.exp(of_library * logs[0] + of_analytic * logs[1]),
        candidates=np.concatenate([library.candidates, analytic.candidates]),
        weight=np.append(of_library * library.weight, of_analytic),
        spread_weight=np.append(of_library * library.spread_weight, of_analytic),
        parts=parts,
        model="both",
    )


def _said(analytic: ContactFront, library: ContactFront) -> str:
    return (
        f"The pins do not move as on any dome of the library ({library.misfit:.0%} of the motion is left over), but as "
        f"over a skin that is flattened and stretched evenly ({analytic.misfit:.0%}): the edge is taken from that."
    )
