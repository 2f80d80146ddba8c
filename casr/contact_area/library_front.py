"""The front of a press by the library of finite-element domes, and what its error is made of."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from casr.camera import Camera, distorted, undistorted
from casr.contact_area.front import LEAST_PINS, ContactFront
from casr.contact_area.front_fit import POLE_SD_MM, FrontFit, HeldFit, fit_front
from casr.dome.library import Library, tables_of, worlds
from casr.dome.view import INNER_RADIUS_MM, OUTER_RADIUS_MM, DomeView, Pole
from casr.errors import CameraError

Array = NDArray[np.float64]

_OUTLINE = 90


class FrontEdge:
    """The edge by the best world in the last frames, so many, against the pins."""

    def __init__(self, fit: FrontFit, library: Library, rest_px: Array, n_frames: int) -> None:
        self._fit, self._library = fit, library
        view, world = fit.view, int(fit.worlds[0])
        self._radius_mm = fit.radius_mm[0, -n_frames:]
        outer_arc_mm = np.interp(self._radius_mm, library.radius_mm, library.edge_arc_mm[world])
        self._arc_mm = outer_arc_mm * INNER_RADIUS_MM / OUTER_RADIUS_MM
        directions = view.directions(rest_px)
        arc_mm = view.around(directions, fit.axis).arc_mm
        self.inside = arc_mm <= self._arc_mm[:, None]
        self.pins_inside = self.inside.sum(axis=1)
        near = directions[np.argsort(arc_mm)[: 2 * LEAST_PINS]]
        angles = np.arccos(np.clip(near @ near.T, -1, 1)) + 9 * np.eye(len(near))
        self.pitches = self._arc_mm / (INNER_RADIUS_MM * float(np.median(angles.min(axis=1))))

    def outline_px(self) -> Array:
        """(T, M, 2) px: where tips of pins on the edge would be seen."""
        fit, library = self._fit, self._library
        turn = np.linspace(0, 2 * np.pi, _OUTLINE, endpoint=False)
        across = np.linalg.svd(fit.axis[None])[2][1:]
        around = np.cos(turn)[:, None] * across[0] + np.sin(turn)[:, None] * across[1]
        angle = (self._arc_mm / INNER_RADIUS_MM)[:, None, None]
        directions = (np.cos(angle) * fit.axis + np.sin(angle) * around).reshape(-1, 3)
        row = np.interp(self._radius_mm, library.radius_mm, np.arange(library.radius_mm.size))
        low = np.minimum(row.astype(np.intp), library.radius_mm.size - 2)
        u = library.only(fit.worlds[:1]).motion_at(self._arc_mm, np.float64)[..., 0]
        frames = np.arange(len(row))
        u = (1 - row + low) * u[:, frames, low] + (row - low) * u[:, frames, low + 1]
        moved_px = fit.view.around(directions, fit.axis).moved_px(*np.repeat(u, _OUTLINE, axis=1))
        return np.asarray((fit.view.rest_px(directions) + moved_px).reshape(len(row), _OUTLINE, 2))


def as_a_whole(rest_px: Array, pins_px: Array, inside: NDArray[np.bool_]) -> tuple[Array, Array]:
    """Shear and torsion of a contact: (T, 2) mean motion, px, and (T,) turn, degrees, of the pins inside (T, N).

    Pins (T, N, 2) that were at (N, 2) at rest; NaN where none is seen inside, and for the turn fewer than three.
    """
    shear, torsion = np.full((len(pins_px), 2), np.nan), np.full(len(pins_px), np.nan)
    for t, (now, within) in enumerate(zip(pins_px, inside, strict=True)):
        rows = np.flatnonzero(within & np.isfinite(now[:, 0]))
        if rows.size:
            shear[t] = (now[rows] - rest_px[rows]).mean(axis=0)
        if rows.size >= 3:
            before, after = (points[rows] - points[rows].mean(axis=0) for points in (rest_px, now))
            cross = (before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]).sum()
            torsion[t] = np.rad2deg(np.arctan2(cross, (before * after).sum()))
    return shear, torsion


SHARPNESS, SPREAD_SHARPNESS = 30.0, 10.0
"Powers of the misfit that weigh worlds: for the estimate, and for how far they differ."
DOME_SD, DOME_SD_PER_MISFIT = 0.005, 0.6
"""Relative standard error of an area although all worlds agree: a dome that the library does not have shows in the
motion that is left over. Of 180 presses to 5 N of domes left out, misfit .01, .016, .023, .029, .036, .045: areas 1.2,
1.5, 2.0, 2.4, 2.4, 4.3 % off, CASR 0.9, 1.7, 2.6, 2.5, 2.2, 3.4 % (root of the mean square)."""
BEYOND_COMPUTED_SD = 0.04
"""Relative standard error of an area for each e-fold by which it is larger than any that was computed: domes continued
by another rule than the library are up to 3.5 % larger at 7 N, a third beyond."""
FREE_MISFIT = 0.03
"Share of the motion that a dome of the library leaves over; more, and the sensor is none of them."
PULLED_FREE_MISFIT = 0.04
"The same where friction pulls the contact along the surface: presses of the emulated rig leave 1.6 to 3.6 %."
SHEARED_MISFIT = FREE_MISFIT
"""From here on friction on a slope is asked whether it pulls the contact along the surface, and believed where that
halves the misfit about the same pole, as one that is free follows a pull: presses of the emulated rig at 30 and 45
degrees go from 0.09 to 0.13 to 0.02 to 0.04. Where nothing pulls it has never acted
(benchmarks/results/sheared_contacts)."""
SD_PER_MISFIT = 4.0
"Relative standard error of an area per misfit above that: 0.05 more came with areas 20 % off on a wrong dome."
PIN_LENGTH_SD_MM, DEPTH_SHARE_SD = 0.1, 0.01
"Standard errors of pin length and (relative) of depth where the camera file states no errors."
SAME_RADIUS = 0.005
"Share by which the radius in a camera file may differ from that of the tables: it is written with four digits."
BEYOND_COMPUTED = 1.25
"Times the largest radius of a table: presses to 7 N reach 1.15 of it."
USUAL_PIN_LENGTHS_MM = (1.5, 2.5, 3.5, 4.5)
LONGEST_PIN = 0.5
"Longest pin, as a share of the radius on which pins stand: longer ones would meet."
UNKNOWN_REACH_DEG = (40.0, 55.0, 70.0)
"Angles of the outermost pins from the pole that are tried where no camera says how large the dome is."
_UNKNOWN_DEPTH_MM = 50.0
_KEPT = 24


def found_fits(
    rest_px: Array,
    pins_px: Array,
    camera: Camera | None,
    library: Library,
    near: Sequence[HeldFit] | None = None,
    looks: int = 2,
) -> list[HeldFit]:
    """The worlds that explain T frames best, for each of the sensors that it may be, pulled along the surface or not.

    rest_px, pins_px : (N, 2) and (T, N, 2), px. camera : of ``library_front``.
    near : earlier fits of the same press, from whose centres new ones and their worlds are found.
    looks : of ``fit_front``.
    CameraError : as ``library_front``.
    """
    flat_rest, flat_pins = undistorted(rest_px, camera), undistorted(pins_px, camera)
    views, free = _views(flat_rest, camera)[0], camera is not None

    def found(begun: Sequence[HeldFit | None], looks: int, **how: bool) -> list[HeldFit]:
        return [
            fit_front(view, library, flat_rest, flat_pins, near=fit, looks=looks, free_pole=free, **how)
            for view, fit in zip(views, begun, strict=True)
        ]

    fits = found(near or [None] * len(views), looks)
    if _misfit(_best(fits).fit, flat_pins) > SHEARED_MISFIT:
        sheared = found(fits, 1, sheared=True)
        pulled = _best(sheared)
        still = fit_front(pulled.view, library, flat_rest, flat_pins, near=pulled, looks=1)
        if _misfit(pulled.fit, flat_pins) < _misfit(still.fit, flat_pins) / 2:
            return sheared
    return fits


def _best(fits: Sequence[HeldFit]) -> HeldFit:
    return min(fits, key=lambda each: each.best)


def length_errors(
    camera: Camera | None, pin_sd_mm: float = PIN_LENGTH_SD_MM, depth_sd: float = DEPTH_SHARE_SD
) -> tuple[float, float]:
    """Standard errors of the length of pins, mm, and of the depth, relative: as the camera file states them, or else
    these."""
    if camera is not None and camera.depth_sd_mm is not None:
        depth_sd = camera.depth_sd_mm / camera.depth_mm
    if camera is not None and camera.sensor.pin_length_mm is not None:
        pin_sd_mm = camera.sensor.pin_length_sd_mm or pin_sd_mm
    return pin_sd_mm, depth_sd


def library_front(rest_px: Array, pins_px: Array, camera: Camera | None, library: Library) -> ContactFront:
    """The contact in T frames.

    rest_px : (N, 2) pins at rest. pins_px : (T, N, 2) the same pins in contact; NaN where one is lost.
    camera : None leaves areas in px^2, and the size of the dome unknown.
    Tables and errors: decisions 22 and 51.
    """
    fits = found_fits(rest_px, pins_px, camera, library)
    return HeldFront(rest_px, pins_px, camera, library, fits).front


class HeldFront:
    """The front of a press by centres and worlds that stay, in the frames as they come.

    rest_px, pins_px, camera : of ``library_front``. fits : of ``found_fits`` for these frames.
    """

    def __init__(
        self, rest_px: Array, pins_px: Array, camera: Camera | None, library: Library, fits: Sequence[HeldFit]
    ) -> None:
        self._camera, self._library, self._fits = camera, library, fits
        self._rest_px, self._pins_px = undistorted(rest_px, camera), np.empty((0, *rest_px.shape))
        self._views, self._said = _views(self._rest_px, camera)
        self._whose = _best(fits)
        self._world = self._whose.best[1]
        view, (pin_sd_mm, depth_sd) = self._whose.view, length_errors(camera)
        other = {} if camera is None else {
            "pin length": replace(view, pin_length_mm=view.pin_length_mm + pin_sd_mm / dome_scale(camera)),
            "depth": replace(view, depth_mm=view.depth_mm * (1 + depth_sd)),
        }  # fmt: skip
        self._other = {name: self._whose.seen_by(each, library) for name, each in other.items()}
        self._edges: list[tuple[Array, ...]] = []
        self._extend(undistorted(pins_px, camera))

    def __len__(self) -> int:
        return len(self._pins_px)

    def add(self, pins_px: Array) -> None:
        """Further frames: pins (T, N, 2), px."""
        flat_pins = undistorted(pins_px, self._camera)
        for fit in self._fits:
            fit.add(flat_pins)
        self._extend(flat_pins)

    def _extend(self, flat_pins: Array) -> None:
        for fit in self._other.values():
            fit.add(flat_pins)
        edge = FrontEdge(_best(self._fits).fit, self._library, self._rest_px, len(flat_pins))
        outline_px = distorted(edge.outline_px(), self._camera)
        whole = as_a_whole(self._rest_px, flat_pins, edge.inside)
        self._edges.append((outline_px, edge.inside, edge.pins_inside, edge.pitches, *whole))
        self._pins_px = np.concatenate([self._pins_px, flat_pins])

    @property
    def front(self) -> ContactFront:
        """In all frames."""
        camera, library, every_fit = self._camera, self._library, [each.fit for each in self._fits]
        best = min(every_fit, key=lambda fit: fit.misfit_px2[0])
        every = ((misfit, fit, row) for fit in every_fit for row, misfit in enumerate(fit.misfit_px2.tolist()))
        ranked = sorted(every, key=lambda each: each[0])[:_KEPT]
        # what one mm^2 of the dome of 20 mm is in the unit of areas
        unit = [
            fit.view.focal_px[0] * fit.view.focal_px[1] / fit.view.depth_mm**2
            if camera is None
            else dome_scale(camera) ** 2
            for _, fit, _ in ranked
        ]
        candidates = np.pi * np.array([fit.radius_mm[row] for _, fit, row in ranked]) ** 2 * np.array(unit)[:, None]
        log_misfit = np.log([misfit for misfit, _, _ in ranked])
        weight, spread_weight = (_softmax(-power * log_misfit) for power in (SHARPNESS, SPREAD_SHARPNESS))
        log_area = np.log(candidates)
        area = np.exp(weight @ log_area)
        misfit = _misfit(best, self._pins_px)
        usual = PULLED_FREE_MISFIT if best.sheared else FREE_MISFIT
        dome_sd = float(np.hypot(DOME_SD, DOME_SD_PER_MISFIT * misfit))
        # radii differ by s, areas by 2 s: logarithms of areas are compared here, twice their spread as for radii
        spread = np.hypot(2 * np.sqrt(spread_weight @ (log_area - np.log(area)) ** 2), dome_sd)
        parts = self._errors(best, spread, SD_PER_MISFIT * max(misfit - usual, 0.0))
        edge_px, inside, pins_inside, pitches, shear, torsion = map(np.concatenate, zip(*self._edges, strict=True))
        return ContactFront(
            area=area, candidates=candidates, weight=weight, spread_weight=spread_weight, parts=parts,
            centre_px=distorted(best.view.rest_px(best.axis[None]), camera)[0],
            edge_px=edge_px, inside=inside, pins_inside=pins_inside, pitches=pitches, misfit=misfit,
            off_library=misfit, usual_misfit=usual,
            model="finite elements", model_sd=dome_sd, dome=str(library.dome[best.worlds[0]]),
            stiffness_n_per_mm=float(library.stiffness_n_per_mm[best.worlds[0]]), log_misfit=_by_dome(ranked, library),
            shear_px=shear, torsion_deg=torsion,
            notes=(*self._said, *_notes(misfit, usual, best, library, self._views[0].pole_px)),
        )  # fmt: skip

    def _errors(self, best: FrontFit, dome: Array, misfit_sd: float) -> dict[str, Array]:
        """Standard error of ln area (T,) by cause. dome : (T,) that of the dome, from how its candidates differ."""
        held_mm = self._whose.radius_mm[self._world]
        beyond = np.maximum(best.radius_mm[0] / self._library.computed_mm[best.worlds[0]], 1.0)
        return {
            "pins": 2 * best.scatter[0],
            "dome": dome,
            "misfit": np.full(len(dome), misfit_sd),
            "pin length": np.zeros(len(dome)), "depth": np.zeros(len(dome)),
            **{name: 2 * np.log(fit.radius_mm[0] / held_mm) for name, fit in self._other.items()},
            "beyond the tables": 2 * BEYOND_COMPUTED_SD * np.log(beyond),
        }  # fmt: skip


def _views(rest_px: Array, camera: Camera | None) -> tuple[list[DomeView], tuple[str, ...]]:
    """Views of the sensor that are possible, with the errors of what is not known. Millimetres are those of a dome of
    20 mm outer radius.

    The pole is the principal point, from which a press may find another one; without a camera the mean of the pins.
    """
    pole = rest_px.mean(axis=0) if camera is None else np.array([camera.cx_px, camera.cy_px])
    pole_px = (float(pole[0]), float(pole[1]))
    sensor = camera.sensor if camera is not None else None
    scale = dome_scale(camera)
    known_mm = None if sensor is None else sensor.pin_length_mm
    lengths = USUAL_PIN_LENGTHS_MM if known_mm is None else (known_mm / scale,)
    said: tuple[str, ...] = ()
    longest_mm = LONGEST_PIN * INNER_RADIUS_MM * scale
    if known_mm is not None and known_mm > longest_mm:
        raise CameraError(
            "sensor.pin_length_mm", wanted=f"{longest_mm:.3g} mm or less in a dome of {OUTER_RADIUS_MM * scale:g} mm",
            found=f"{known_mm:g}",
            do="Measure from the skin to the tip of a pin; give dome_radius_mm if the dome is not of 20 mm.",
        )  # fmt: skip
    if known_mm is None:
        tried = ", ".join(f"{each:g}" for each in lengths)
        said = (
            f"Pin length is not known: {tried} mm were tried. Half a millimetre is worth 20 % of "
            "the area at 0.5 N; give pin_length_mm under [sensor] in camera.toml.",
        )
    if camera is not None:
        focal = (camera.fx_px, camera.fy_px)
        views = [
            DomeView(focal_px=focal, pole_px=pole_px, depth_mm=camera.depth_mm / scale, pin_length_mm=length)
            for length in lengths
        ]
        return views, said
    said += (
        "No camera.toml: how large the dome is in the image is not known, so the absolute area depends on what is "
        "assumed of it.",
    )
    reach_px = float(np.hypot(*(rest_px - pole).T).max())
    views = [_unscaled(pole_px, reach_px, length, angle) for length in lengths[1::2] for angle in UNKNOWN_REACH_DEG]
    return views, said


def _unscaled(pole_px: tuple[float, float], reach_px: float, pin_length_mm: float, reach_deg: float) -> DomeView:
    """The view in which the outermost pins stand at an angle from the pole."""
    tip_mm, angle = INNER_RADIUS_MM - pin_length_mm, np.deg2rad(reach_deg)
    away_mm = _UNKNOWN_DEPTH_MM - tip_mm + tip_mm * np.cos(angle)
    focal = float(reach_px * away_mm / (tip_mm * np.sin(angle)))
    return DomeView(focal_px=(focal, focal), pole_px=pole_px, depth_mm=_UNKNOWN_DEPTH_MM, pin_length_mm=pin_length_mm)


def dome_scale(camera: Camera | None) -> float:
    """Millimetres of this sensor in one of the dome of 20 mm."""
    radius = None if camera is None else camera.sensor.dome_radius_mm
    return 1.0 if radius is None else radius / OUTER_RADIUS_MM


def worlds_for(camera: Camera | None, domes: str | None, specimen_height_mm: float | None) -> Library:
    """Worlds that the front of a press of this sensor is compared with.

    domes : folder of a lab's own tables. specimen_height_mm : of the specimen, mm; None: tables of any height.
    Errors of ``casr.dome.library.worlds`` and ``height_in_tables``.
    """
    return worlds(domes, height_in_tables(camera, domes, specimen_height_mm))


def height_in_tables(camera: Camera | None, domes: str | None, specimen_height_mm: float | None) -> float | None:
    """The height in millimetres of tables of domes. CameraError : they were solved for a sensor of another radius."""
    scale = dome_scale(camera)
    for table in tables_of(domes) if domes and camera else ():
        if abs(OUTER_RADIUS_MM * scale / table.dome_radius_mm - 1) > SAME_RADIUS:  # not where the table does not say
            raise CameraError(
                "sensor.dome_radius_mm", wanted=f"{table.dome_radius_mm:.4g} mm, as the tables in {domes} were solved",
                found=f"{OUTER_RADIUS_MM * scale:.4g} mm",
                do="Give that radius under [sensor] in camera.toml, or the tables of this sensor.",
            )  # fmt: skip
    return specimen_height_mm and specimen_height_mm / scale


def _misfit(fit: FrontFit, pins_px: Array) -> float:
    """Share of the motion left over beyond the scatter of pins from frame to frame."""
    left = float(fit.misfit_px2[0])
    if len(pins_px) >= 5:
        bend = pins_px[:-2] - 2 * pins_px[1:-1] + pins_px[2:]
        scatter_px2 = float(np.nanmedian(bend**2)) / 0.4549 / 6  # median of chi squared with one degree of freedom
        left -= scatter_px2 * 2 * int(np.isfinite(pins_px[..., 0]).sum())
    return float(np.sqrt(max(left, 0.0) / max(fit.moved_px2, 1e-12)))


def _notes(misfit: float, usual: float, fit: FrontFit, library: Library, stated_px: Pole) -> tuple[str, ...]:
    notes: list[str] = []
    (x, y), (stated_x, stated_y) = fit.view.pole_px, stated_px
    if np.hypot(x - stated_x, y - stated_y) > POLE_SD_MM * fit.view.focal_px[0] / fit.view.depth_mm:
        notes.append(
            f"By the pins the axis of the dome meets the image at ({x:.0f}, {y:.0f}) px, not at cx_px and cy_px of "
            f"camera.toml, ({stated_x:.0f}, {stated_y:.0f}): the place by the pins is taken."
        )
    if misfit > usual:
        notes.append(
            f"The pins do not move as on any dome of the library: {misfit:.0%} of the motion is left over "
            f"({usual:.0%} would be usual), so the size of the contact depends on the dome assumed."
        )
    beyond = int((fit.radius_mm[0] > BEYOND_COMPUTED * library.computed_mm[fit.worlds[0]]).sum())
    if beyond:
        notes.append(
            f"In {beyond} of {fit.radius_mm.shape[1]} frames the contact is larger by a quarter than any that "
            "was computed: the tables are continued there."
        )
    return tuple(notes)


def _by_dome(ranked: list[tuple[float, FrontFit, int]], library: Library) -> dict[str, float]:
    least: dict[str, float] = {}
    for misfit, fit, row in ranked:
        least.setdefault(str(library.dome[fit.worlds[row]]), float(np.log(misfit)))
    return least


def _softmax(power: Array) -> Array:
    weight = np.exp(power - power.max())
    return np.asarray(weight / weight.sum())
