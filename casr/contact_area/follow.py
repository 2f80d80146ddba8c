"""The front door of the contact front: the library of domes, or the analytic field of ``edge``."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from casr.camera import Camera, undistorted
from casr.contact_area.edge import ContactEdge, fit_edge
from casr.contact_area.front import PARTS, ContactFront
from casr.contact_area.front_fit import HeldFit
from casr.contact_area.library_front import (
    FREE_MISFIT,
    SD_PER_MISFIT,
    HeldFront,
    as_a_whole,
    found_fits,
    length_errors,
    library_front,
)
from casr.contact_area.motion import pin_motion
from casr.dome.library import Library
from casr.errors import PinsError
from casr.flow.region import Region
from casr.pins import pin_pitch_px

Array = NDArray[np.float64]

_FITTED_FRAMES = 16
"Areas between them follow along lines of ln A over the number of the frame."
ANALYTIC_SD = 0.05
"Relative standard error of an area although the field explains the motion: 3 % was seen in the worlds that move so."


def analytic_front(rest_px: Array, pins_px: Array, camera: Camera | None) -> ContactFront:
    """The contact in T frames, as the ellipse whose field is nearest to the motion of the pins.

    rest_px : (N, 2) pins at rest. pins_px : (T, N, 2) the same pins in contact; NaN where one is lost.
    camera : None leaves areas in px^2.
    The field is that of decision 7.
    """
    n_frames = len(pins_px)
    fitted = np.unique(np.linspace(0, n_frames - 1, _FITTED_FRAMES).round().astype(np.intp))
    edges: list[ContactEdge] = []
    outlines: list[Array] = []
    near: ContactEdge | None = None
    for frame in fitted[::-1].tolist():  # the last is the largest, and the surest to begin with
        motion = pin_motion(rest_px, pins_px[frame])
        near = fit_edge(motion, near)
        edges.insert(0, near)
        outlines.insert(0, near.at_contact(motion).polygon_px)
    areas = np.array([Region(undistorted(outline, camera)).area_px2 for outline in outlines])
    scale = 1.0 if camera is None else camera.mm2_per_px2
    area = scale * np.exp(np.interp(np.arange(n_frames), fitted, np.log(areas)))
    outline_px = _between(np.array(outlines), fitted, n_frames)
    size = np.interp(np.arange(n_frames), fitted, [np.sqrt(edge.a_px * edge.b_px) for edge in edges])
    grown = np.interp(np.arange(n_frames), fitted, [1 + edge.stretch for edge in edges])
    centre = np.mean([edge.centre_px for edge in edges], axis=0)
    away = np.hypot(*(rest_px - centre).T)
    inside = away <= size[:, None]
    left = np.array([1 - edge.explained for edge in edges])
    moved = np.array([float(np.nansum((pins_px[frame] - rest_px) ** 2)) for frame in fitted])
    shear, torsion = as_a_whole(rest_px, pins_px, inside)
    scatter = np.interp(np.arange(n_frames), fitted, [edge.area_error for edge in edges])
    misfit = float(np.sqrt(max(left @ moved, 0.0) / max(moved.sum(), 1e-12)))
    parts = (
        scatter,
        np.full(n_frames, ANALYTIC_SD),
        np.full(n_frames, SD_PER_MISFIT * max(misfit - FREE_MISFIT, 0.0)),
        np.zeros(n_frames),
        np.full(n_frames, 0.0 if camera is None else 2 * length_errors(camera)[1]),
        np.zeros(n_frames),
    )
    return ContactFront(
        area=area, candidates=area[None], weight=np.ones(1), spread_weight=np.ones(1),
        parts=dict(zip(PARTS, parts, strict=True)), centre_px=centre, edge_px=outline_px, inside=inside,
        pins_inside=inside.sum(axis=1), pitches=size * grown / pin_pitch_px(rest_px), misfit=misfit, off_library=np.nan,
        usual_misfit=np.nan,
        model="analytic", model_sd=ANALYTIC_SD, dome="", stiffness_n_per_mm=np.nan, log_misfit={}, shear_px=shear,
        torsion_deg=torsion, notes=(),
    )  # fmt: skip


def _between(outlines: Array, fitted: NDArray[np.intp], n_frames: int) -> Array:
    after = np.clip(np.searchsorted(fitted, np.arange(n_frames)), 1, len(fitted) - 1)
    share = ((np.arange(n_frames) - fitted[after - 1]) / (fitted[after] - fitted[after - 1]))[:, None, None]
    return np.asarray((1 - share) * outlines[after - 1] + share * outlines[after])


FEWEST_PINS, FEWEST_FRAMES = 7, 2
ELSEWHERE = 0.06
"""Misfit of the library from which on the analytic field is fitted, too. It is taken where it leaves over no more than
a dome of the library does of its own presses (``FREE_MISFIT``): 0.3 to 1.5 % where skin stretches as it says, 4 to 23 %
on every dome of finite elements, whose areas it has wrong by up to half."""
MAY_FIND, MUST_FIND = 2.0, 4.0
"""Times the frames from which centre and worlds were found last, from which on they are found again. After twice the
frames areas by those found anew differ by 0.05 %."""
EXPLAINED, MOST_SHARE = 0.05, 0.5
"Misfit of the analytic field from which on so much of its distance to the library's areas is a standard error."


def contact_front(
    rest_px: Array, pins_px: Array, camera: Camera | None, library: Library, held: HeldFront | None = None
) -> ContactFront:
    """The contact in T frames: by the library of finite-element domes, or analytically where only that explains it.

    rest_px : (N, 2) pins at rest. pins_px : (T, N, 2) the same pins in contact; NaN where one is lost.
    camera : None leaves areas in px^2, and the size of the dome unknown.
    held : of the library, for these frames; None finds it.
    PinsError : fewer than seven pins in some frame, or fewer than two frames. CameraError : pins longer than can be.
    Why the front, and how: decision 22.
    """
    rest_px, pins_px = np.asarray(rest_px, dtype=np.float64), np.asarray(pins_px, dtype=np.float64)
    fewest = int(np.isfinite(pins_px[..., 0]).sum(axis=1).min(initial=len(rest_px)))
    if fewest < FEWEST_PINS or len(pins_px) < FEWEST_FRAMES:
        raise PinsError(
            "contact front", wanted=f"{FEWEST_PINS} pins in every frame, and {FEWEST_FRAMES} frames",
            found=f"{fewest} pins, {len(pins_px)} frames", do="Leave out the frames without pins.",
        )  # fmt: skip
    front = held.front if held else library_front(rest_px, pins_px, camera, library)
    if front.misfit > ELSEWHERE:
        other = analytic_front(rest_px, pins_px, camera)
        front = _analytic(other, front) if other.misfit < FREE_MISFIT else front
    return front.with_note_on_size()


class FrontSoFar:
    """The contact front of a press that goes on: centre and worlds are found now and then, and kept between.

    camera, library : of ``contact_front``.
    """

    def __init__(self, camera: Camera | None, library: Library) -> None:
        self._camera, self._library = camera, library
        self._fits: list[HeldFit] | None = None
        self._found_in = 0
        self.front: ContactFront | None = None
        "Front of the last frames."

    def of(self, rest_px: Array, pins_px: Array) -> ContactFront:
        """The contact in the T frames so far: pins (N, 2) at rest and (T, N, 2), px. Errors of ``contact_front``."""
        if self._fits is None or len(pins_px) >= MUST_FIND * self._found_in:
            self._find(rest_px, pins_px, looks=2)
        elif len(pins_px) > len(self._held):
            self._held.add(pins_px[len(self._held) :])
        self.front = contact_front(rest_px, pins_px, self._camera, self._library, self._held)
        return self.front

    def settle(self, rest_px: Array, pins_px: Array) -> None:
        """Find centre and worlds again if there are many more frames than when they were found: work for the time in
        which no frame waits.

        rest_px, pins_px : (N, 2) and (T, N, 2), px.
        """
        if len(pins_px) >= max(MAY_FIND * self._found_in, FEWEST_FRAMES):
            self._find(rest_px, pins_px, looks=1)

    def _find(self, rest_px: Array, pins_px: Array, looks: int) -> None:
        self._fits = found_fits(rest_px, pins_px, self._camera, self._library, near=self._fits, looks=looks)
        self._held = HeldFront(rest_px, pins_px, self._camera, self._library, self._fits)
        self._found_in = len(pins_px)


def _analytic(analytic: ContactFront, library: ContactFront) -> ContactFront:
    """The analytic model's areas; the less it explains, the more of their distance to the library's is in the error."""
    share = MOST_SHARE * min(analytic.misfit / EXPLAINED, 1.0)
    parts = dict(analytic.parts)
    parts["dome"] = np.hypot(parts["dome"], share * np.abs(np.log(analytic.area / library.area)))
    return replace(
        analytic, candidates=np.stack([analytic.area, library.area]), weight=np.array([1.0, 0.0]),
        spread_weight=np.array([1 - share**2, share**2]), parts=parts, off_library=library.misfit,
        usual_misfit=library.usual_misfit,
        notes=(_said(analytic, library),),
    )  # fmt: skip


def _said(analytic: ContactFront, library: ContactFront) -> str:
    return (
        f"The pins do not move as on any dome of the library ({library.misfit:.0%} of the motion is left over), but as "
        f"over a skin that is flattened and stretched evenly ({analytic.misfit:.0%}): the edge is taken from that."
    )
