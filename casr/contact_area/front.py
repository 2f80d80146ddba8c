"""Contact area of every frame from its front, with what its error is made of, and where it is determined at all."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from casr.camera import Camera
from casr.contact_area.front_fit import FrontFit, fit_front
from casr.dome.library import Library
from casr.dome.view import INNER_RADIUS_MM, DomeView
from casr.errors import PinsError

Array = NDArray[np.float64]

SHARPNESS, SPREAD_SHARPNESS = 30.0, 10.0
"Powers of the misfit that weigh worlds: for the estimate, and for how far they differ."
DOME_SD = 0.025
"""Relative standard error of an area although all worlds agree: domes left out of the library are found 2 % off (median)."""
FREE_MISFIT = 0.03
"Share of the motion that a dome of the library leaves over; more, and the sensor is none of them."
SD_PER_MISFIT = 4.0
"Relative standard error of an area per misfit above that: 0.05 more came with areas 20 % off on a wrong dome."
PIN_LENGTH_SD_MM, DEPTH_SHARE_SD = 0.2, 0.01
USUAL_PIN_LENGTHS_MM = (1.5, 2.5, 3.5, 4.5)
UNKNOWN_REACH_DEG = (40.0, 55.0, 70.0)
"Of the outermost pins from the pole, where no camera says how large the dome is."
_UNKNOWN_DEPTH_MM = 50.0
_OUTER_RADIUS_MM, _SKIN_MM = 20.0, 1.0
LEAST_PITCHES, LEAST_PINS = 1.5, 7
_KEPT = 24
_OUTLINE = 90
_FEWEST = 7
PARTS = ("pins", "dome", "misfit", "pin length", "depth")
"What the standard error of an area is made of."


@dataclass(frozen=True, eq=False)
class ContactFront:
    """The contact of T frames.

    area : (T,) in mm^2, or px^2 at the tips of the pins without a camera. candidates : (K, T) the same by each world
    that explains the press. weight, spread_weight : (K,) of each for the estimate, and for how far they differ.
    parts : name to (T,) relative standard error of ``area``; see ``PARTS``. Pin length and depth keep the sign that
    belongs to longer pins and a larger depth.
    centre_px : (2,) middle of the contact in the rest frame. edge_px : (T, M, 2) its edge in each frame.
    pins_inside : (T,) pins whose roots are inside the edge. pitches : (T,) radius of the contact over the pins' pitch.
    misfit : share of the motion that the best world leaves over beyond the scatter of the pins.
    dome, stiffness_n_per_mm : of that world. log_misfit : name of each dome to the logarithm of its least misfit.
    shear_px, torsion_deg : (T, 2) and (T,) motion of the pins inside as a whole, and their turn about the centre.
    notes : what a reader should know.
    """

    area: Array
    candidates: Array
    weight: Array
    spread_weight: Array
    parts: dict[str, Array]
    centre_px: Array
    edge_px: Array
    pins_inside: NDArray[np.intp]
    pitches: Array
    misfit: float
    dome: str
    stiffness_n_per_mm: float
    log_misfit: dict[str, float]
    shear_px: Array
    torsion_deg: Array
    notes: tuple[str, ...]

    @property
    def relative_sd(self) -> Array:
        """(T,) total relative standard error of ``area``."""
        return np.sqrt(sum(part**2 for part in self.parts.values()))

    @property
    def determined(self) -> NDArray[np.bool_]:
        """(T,) frames in which the contact is large enough against the pitch of the pins."""
        return (self.pitches >= LEAST_PITCHES) & (self.pins_inside >= LEAST_PINS)


def contact_front(rest_px: Array, pins_px: Array, camera: Camera | None, library: Library) -> ContactFront:
    """The contact in T frames.

    Parameters
    ----------
    rest_px : (N, 2) pins at rest. pins_px : (T, N, 2) the same pins in contact; NaN where one is lost.
    camera : None leaves areas in px^2, and the size of the dome unknown.

    Raises
    ------
    PinsError : fewer than seven pins in some frame.
    """
    rest_px, pins_px = np.asarray(rest_px, dtype=np.float64), np.asarray(pins_px, dtype=np.float64)
    fewest = int(np.isfinite(pins_px[..., 0]).sum(axis=1).min(initial=len(rest_px)))
    if fewest < _FEWEST:
        raise PinsError(
            "contact front", wanted=f"{_FEWEST} pins in every frame", found=f"{fewest}",
            do="Leave out the frames without pins.",
        )  # fmt: skip
    flat_rest, flat_pins = _undistorted(rest_px, camera), _undistorted(pins_px, camera)
    views, said = _views(flat_rest, camera)
    fits = [fit_front(view, library, flat_rest, flat_pins) for view in views]
    best = min(fits, key=lambda fit: fit.misfit_px2[0])
    ranked = sorted(
        ((misfit, fit, row) for fit in fits for row, misfit in enumerate(fit.misfit_px2.tolist())), key=lambda each: each[0]
    )[:_KEPT]
    unit = np.array([_area_unit(fit.view, camera) for _, fit, _ in ranked])
    candidates = np.pi * np.array([fit.radius_mm[row] for _, fit, row in ranked]) ** 2 * unit[:, None]
    log_misfit = np.log([misfit for misfit, _, _ in ranked])
    weight, spread_weight = (_softmax(-power * log_misfit) for power in (SHARPNESS, SPREAD_SHARPNESS))
    log_area = np.log(candidates)
    area = np.exp(weight @ log_area)
    misfit = _misfit(best, flat_pins)
    length = len(area)
    parts = {
        "pins": 2 * best.scatter[0],
        # radii differ by s, areas by 2 s: the logarithms of areas are compared here, twice their spread as for radii
        "dome": np.hypot(2 * np.sqrt(spread_weight @ (log_area - np.log(area)) ** 2), DOME_SD),
        "misfit": np.full(length, SD_PER_MISFIT * max(misfit - FREE_MISFIT, 0.0)),
        "pin length": _sensitivity(best, library, flat_rest, flat_pins, camera, pin_length=PIN_LENGTH_SD_MM),
        "depth": _sensitivity(best, library, flat_rest, flat_pins, camera, depth_share=DEPTH_SHARE_SD),
    }
    edge = _Edge(best, library, flat_rest)
    shear, torsion = edge.as_a_whole(flat_rest, flat_pins)
    front = ContactFront(
        area=area,
        candidates=candidates,
        weight=weight,
        spread_weight=spread_weight,
        parts=parts,
        centre_px=_distorted(best.view.rest_px(best.axis[None]), camera)[0],
        edge_px=_distorted(edge.outline_px(), camera),
        pins_inside=edge.pins_inside,
        pitches=edge.pitches,
        misfit=misfit,
        dome=str(library.dome[best.worlds[0]]),
        stiffness_n_per_mm=float(library.stiffness_n_per_mm[best.worlds[0]]),
        log_misfit=_by_dome(ranked, library),
        shear_px=shear,
        torsion_deg=torsion,
        notes=said,
    )
    return replace(front, notes=(*said, *_notes(front, best, library)))


def _views(rest_px: Array, camera: Camera | None) -> tuple[list[DomeView], tuple[str, ...]]:
    """What the sensor may be, and what is not known of it. Millimetres are those of a dome of 20 mm outer radius."""
    pole = rest_px.mean(axis=0)
    pole_px = (float(pole[0]), float(pole[1]))
    sensor = camera.sensor if camera is not None else None
    scale = _scale(camera)
    lengths = USUAL_PIN_LENGTHS_MM if sensor is None or sensor.pin_length_mm is None else (sensor.pin_length_mm / scale,)
    said: tuple[str, ...] = ()
    if len(lengths) > 1:
        said = (
            f"Pin length is not known: {', '.join(f'{each:g}' for each in lengths)} mm were tried. Half a millimetre is "
            "worth 20 % of the area at 0.5 N; give pin_length_mm under [sensor] in camera.toml.",
        )
    if camera is not None:
        focal = (camera.fx_px, camera.fy_px)
        views = [
            DomeView(focal_px=focal, pole_px=pole_px, depth_mm=camera.depth_mm / scale, pin_length_mm=length)
            for length in lengths
        ]
        return views, said
    said += ("No camera.toml: the size of the dome in the image is not known, so the absolute area depends on the dome assumed.",)
    reach_px = float(np.hypot(*(rest_px - pole).T).max())
    return [_unscaled(pole_px, reach_px, length, angle) for length in lengths[1::2] for angle in UNKNOWN_REACH_DEG], said


def _unscaled(pole_px: tuple[float, float], reach_px: float, pin_length_mm: float, reach_deg: float) -> DomeView:
    """The view in which the outermost pins stand at an angle from the pole."""
    tip_mm, angle = INNER_RADIUS_MM - pin_length_mm, np.deg2rad(reach_deg)
    away_mm = _UNKNOWN_DEPTH_MM - tip_mm + tip_mm * np.cos(angle)
    focal = float(reach_px * away_mm / (tip_mm * np.sin(angle)))
    return DomeView(focal_px=(focal, focal), pole_px=pole_px, depth_mm=_UNKNOWN_DEPTH_MM, pin_length_mm=pin_length_mm)


def _scale(camera: Camera | None) -> float:
    """Millimetres of this sensor in one of the dome of 20 mm."""
    radius = None if camera is None else camera.sensor.dome_radius_mm
    return 1.0 if radius is None else radius / _OUTER_RADIUS_MM


def _area_unit(view: DomeView, camera: Camera | None) -> float:
    """What one mm^2 of the dome of 20 mm is in the unit of areas."""
    if camera is not None:
        return _scale(camera) ** 2
    return view.focal_px[0] * view.focal_px[1] / view.depth_mm**2


def _misfit(fit: FrontFit, pins_px: Array) -> float:
    """Share of the motion left over beyond the scatter of pins from frame to frame."""
    left = float(fit.misfit_px2[0])
    if len(pins_px) >= 5:
        bend = pins_px[:-2] - 2 * pins_px[1:-1] + pins_px[2:]
        scatter_px2 = float(np.nanmedian(bend**2)) / 0.4549 / 6  # median of chi squared with one degree of freedom
        left -= scatter_px2 * 2 * int(np.isfinite(pins_px[..., 0]).sum())
    return float(np.sqrt(max(left, 0.0) / max(fit.moved_px2, 1e-12)))


def _sensitivity(
    fit: FrontFit,
    library: Library,
    rest_px: Array,
    pins_px: Array,
    camera: Camera | None,
    *,
    pin_length: float = 0.0,
    depth_share: float = 0.0,
) -> Array:
    """(T,) change of ln area when pins are longer by ``pin_length`` mm, or depth is larger by a share."""
    if camera is None:
        return np.zeros(len(pins_px))
    view = fit.view
    other = replace(
        view, pin_length_mm=view.pin_length_mm + pin_length / _scale(camera), depth_mm=view.depth_mm * (1 + depth_share)
    )
    one = replace(fit, worlds=fit.worlds[:1])
    return 2 * np.log(fit_front(other, library, rest_px, pins_px, like=one).radius_mm[0] / fit.radius_mm[0])


class _Edge:
    """The edge by the best world, against the pins."""

    def __init__(self, fit: FrontFit, library: Library, rest_px: Array) -> None:
        self._fit, self._library = fit, library
        view, world = fit.view, int(fit.worlds[0])
        self._radius_mm = fit.radius_mm[0]
        outer = INNER_RADIUS_MM + _SKIN_MM
        self._arc_mm = np.interp(self._radius_mm, library.radius_mm, library.edge_arc_mm[world]) * INNER_RADIUS_MM / outer
        directions = view.directions(rest_px)
        arc_mm = view.around(directions, fit.axis).arc_mm
        self._inside = arc_mm <= self._arc_mm[:, None]
        self.pins_inside = self._inside.sum(axis=1)
        near = directions[np.argsort(arc_mm)[: 2 * LEAST_PINS]]
        angles = np.arccos(np.clip(near @ near.T, -1, 1)) + 9 * np.eye(len(near))
        self.pitches = self._arc_mm / (INNER_RADIUS_MM * float(np.median(angles.min(axis=1))))

    def outline_px(self) -> Array:
        """(T, M, 2) where tips of pins on the edge would be seen."""
        fit, library = self._fit, self._library
        turn = np.linspace(0, 2 * np.pi, _OUTLINE, endpoint=False)
        across = np.linalg.svd(fit.axis[None])[2][1:]
        around = np.cos(turn)[:, None] * across[0] + np.sin(turn)[:, None] * across[1]
        outlines = []
        for radius, arc in zip(self._radius_mm, self._arc_mm, strict=True):
            angle = arc / INNER_RADIUS_MM
            directions = np.cos(angle) * fit.axis + np.sin(angle) * around
            row = float(np.interp(radius, library.radius_mm, np.arange(library.radius_mm.size)))
            low = min(int(row), library.radius_mm.size - 2)
            u = library.motion_at(np.full(1, arc), fit.worlds[:1], slice(low, low + 2))[:, 0, :, 0].astype(np.float64)
            u_r, u_z, tilt = (np.full(_OUTLINE, (1 - row + low) * each[0] + (row - low) * each[1]) for each in u)
            pins = fit.view.around(directions, fit.axis)
            outlines.append(fit.view.rest_px(directions) + pins.moved_px(u_r, u_z, tilt))
        return np.array(outlines)

    def as_a_whole(self, rest_px: Array, pins_px: Array) -> tuple[Array, Array]:
        """(T, 2) mean motion and (T,) turn in degrees of the pins inside; NaN where none is seen there."""
        shear, torsion = np.full((len(pins_px), 2), np.nan), np.full(len(pins_px), np.nan)
        for t, (now, inside) in enumerate(zip(pins_px, self._inside, strict=True)):
            rows = np.flatnonzero(inside & np.isfinite(now[:, 0]))
            if rows.size:
                shear[t] = (now[rows] - rest_px[rows]).mean(axis=0)
            if rows.size >= 3:
                before, after = (points[rows] - points[rows].mean(axis=0) for points in (rest_px, now))
                cross = (before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]).sum()
                torsion[t] = np.rad2deg(np.arctan2(cross, (before * after).sum()))
        return shear, torsion


def _notes(front: ContactFront, fit: FrontFit, library: Library) -> tuple[str, ...]:
    notes: list[str] = []
    if front.misfit > FREE_MISFIT:
        notes.append(
            f"Check this press: the pins do not move as on any dome of the library ({front.misfit:.0%} of the motion is "
            f"left over; {FREE_MISFIT:.0%} would be usual), so the size of the contact depends on the dome assumed."
        )
    small = int((~front.determined).sum())
    if small:
        notes.append(
            f"In {small} of {len(front.area)} frames the contact is smaller than {LEAST_PITCHES:g} pitches or holds fewer "
            f"than {LEAST_PINS} pins: its area is not determined there and does not count."
        )
    beyond = int((fit.radius_mm[0] > library.computed_mm[fit.worlds[0]]).sum())
    if beyond:
        notes.append(f"In {beyond} of {len(front.area)} frames the contact is larger than any that was computed.")
    return tuple(notes)


def _by_dome(ranked: list[tuple[float, FrontFit, int]], library: Library) -> dict[str, float]:
    least: dict[str, float] = {}
    for misfit, fit, row in ranked:
        least.setdefault(str(library.dome[fit.worlds[row]]), float(np.log(misfit)))
    return least


def _softmax(power: Array) -> Array:
    weight = np.exp(power - power.max())
    return np.asarray(weight / weight.sum())


def _undistorted(points_px: Array, camera: Camera | None) -> Array:
    if camera is None or not camera.distortion:
        return points_px
    return camera.undistorted_px(points_px.reshape(-1, 2)).reshape(points_px.shape)


def _distorted(points_px: Array, camera: Camera | None) -> Array:
    if camera is None or not camera.distortion:
        return points_px
    return camera.distorted_px(points_px.reshape(-1, 2)).reshape(points_px.shape)

