"""The default world: finite elements of a dome pressed on soft cylinders, tabulated."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from casr.contact_area.library_front import dome_scale
from casr.dome.library import DEFAULT_WORLD, SHIPPED, Library, of_height, read_library, shipped
from casr.dome.pull import share_pulled
from casr.dome.view import INNER_RADIUS_MM, OUTER_RADIUS_MM, DomeView, PinsAroundAxis
from casr.errors import SettingError
from emg2vsa.worlds.tactile.world import Array, ContactEllipse, ContactState, Points, Pressing

_SHIPPED = (SHIPPED, DEFAULT_WORLD)
_OUTLINE = 360
_SOFTER = 0.8
"Share of the softest table's stiffness: the scatter of specimens."


@cache
def tabulated(tables: str) -> Library:
    """A shipped library by its name, or the tables of a folder. SettingError where there are none."""
    return shipped(tables) if tables in _SHIPPED else read_library(Path(tables))


@dataclass(frozen=True, kw_only=True)
class TabulatedWorld:
    """Dome A of 20 mm (skin 0.8 MPa over gel 0.03 MPa) on cylinders of 35 mm radius and 25 mm height, or own tables.

    Tables are of a dome of 20 mm; the sensor's dome_radius_mm says how large the dome is that they stand for.
    Between tables the motion and the logarithm of the force at a radius are interpolated along compliance^(1/2), which
    is within 7 % of the force for a table left out; above the 5 N of the tables both are continued (casr.dome.library).
    At a tilt the axisymmetric field is turned about the centre of the dome: the clamped base is taken for as far away
    as from a contact at the pole. That is an assumption, named in the truth of a press.

    Parameters
    ----------
    friction : ``stick`` or ``frictionless``.
    dome : of ``tables``; empty: the only one there. tables : name of a shipped library, or a folder of a lab's own
        tables (casr.dome.tables).
    """

    friction: str = "stick"
    dome: str = ""
    tables: str = DEFAULT_WORLD

    def __post_init__(self) -> None:
        library = tabulated(self.tables)
        if not self.dome and len(domes := set(library.dome.tolist())) == 1:
            object.__setattr__(self, "dome", *domes)
        known = sorted(set(zip(library.dome.tolist(), library.friction.tolist(), strict=True)))
        if (self.dome, self.friction) not in known:
            raise SettingError(
                "dome, friction", wanted=", ".join(" ".join(each) for each in known),
                found=f"{self.dome} {self.friction}", do="Choose one of these.",
            )  # fmt: skip

    @property
    def name(self) -> str:
        return f"tabulated, {self.friction}"

    @property
    def assumptions(self) -> tuple[str, ...]:
        return (
            "at a tilt the axisymmetric field is turned about the dome's centre",
            "above 5 N and between the tables' stiffnesses the field is continued and interpolated",
        )

    def press(self, pressing: Pressing) -> TabulatedSkin:
        """The skin of one press."""
        return TabulatedSkin(self, pressing)

    def solution(self, stiffness_n_per_mm: float, height_mm: float | None = None) -> tuple[Array, Array, Array]:
        """(R,) force, (R,) edge on the inside of the skin and (R, S, 3) motion, for each radius of the tables.

        height_mm : of the specimen, mm of a dome of 20 mm; None: the only one of the tables.
        SettingError : a specimen softer than the tables reach, or of another stiffness than the only table has.
        """
        library = self._of_height(height_mm)
        rows = np.flatnonzero((library.dome == self.dome) & (library.friction == self.friction))
        rows = rows[np.argsort(-library.stiffness_n_per_mm[rows])]
        softness = library.stiffness_n_per_mm[rows] ** -0.5
        at = stiffness_n_per_mm**-0.5
        softest = _SOFTER * float(library.stiffness_n_per_mm[rows[-1]])
        if not stiffness_n_per_mm >= softest:
            raise SettingError(
                "stiffness_n_per_mm", wanted=f"{softest:.3g} N/mm or more, as the tables reach",
                found=f"{stiffness_n_per_mm:g}", do="Take a stiffer specimen, or another world.",
            )  # fmt: skip
        if rows.size == 1:
            if not math.isclose(stiffness_n_per_mm, float(library.stiffness_n_per_mm[rows[0]]), rel_tol=1e-6):
                raise SettingError(
                    "stiffness_n_per_mm", wanted=f"{library.stiffness_n_per_mm[rows[0]]:g} N/mm, as the only table has",
                    found=f"{stiffness_n_per_mm:g}", do="Solve tables of several stiffnesses.",
                )  # fmt: skip
            rows, softness = np.repeat(rows, 2), np.array([0.0, at])
        high = int(np.clip(np.searchsorted(softness, at), 1, rows.size - 1))
        share = (at - softness[high - 1]) / (softness[high] - softness[high - 1])
        stiff, soft = rows[high - 1], rows[high]
        log_force = (1 - share) * np.log(library.force_n[stiff]) + share * np.log(library.force_n[soft])
        edge = (1 - share) * library.edge_arc_mm[stiff] + share * library.edge_arc_mm[soft]
        motion = (1 - share) * library.motion[stiff] + share * library.motion[soft]
        return np.exp(log_force), edge * INNER_RADIUS_MM / OUTER_RADIUS_MM, motion.astype(np.float64)

    def _of_height(self, height_mm: float | None) -> Library:
        library = tabulated(self.tables)
        if height_mm is not None:
            return of_height(library, height_mm)
        soft = (library.dome == self.dome) & np.isfinite(library.stiffness_n_per_mm)
        if (heights := np.unique(library.height_mm[soft].round(2))).size > 1:
            raise SettingError(
                "specimen_height_mm", wanted="the height of the specimen, as the tables have several",
                found=f"none, and tables of {', '.join(f'{each:g}' for each in heights)} mm", do="Give it.",
            )  # fmt: skip
        return library

    def radius_mm(self, force_n: Array | float, stiffness_n_per_mm: float, height_mm: float | None = None) -> Array:
        """Contact radius, mm of a dome of 20 mm, at forces, N, of any shape (scalar or not); arguments and errors of
        ``solution``."""
        log_force = np.log(self.solution(stiffness_n_per_mm, height_mm)[0])
        log_radius = np.log(tabulated(self.tables).radius_mm)
        forces = np.asarray(force_n, dtype=np.float64)
        return np.array([_radius(log_force, log_radius, each) for each in forces.ravel().tolist()]).reshape(
            forces.shape
        )


def _radius(log_force: Array, log_radius: Array, force_n: float) -> float:
    """At a force, between rows of the tables along a power law; below the first one along it to 0."""
    if force_n <= 0:
        return 0.0
    asked = np.log(force_n)
    if asked < log_force[0]:
        start = (log_radius[1] - log_radius[0]) / (log_force[1] - log_force[0])
        return float(np.exp(log_radius[0] + start * (asked - log_force[0])))
    return float(np.exp(np.interp(asked, log_force, log_radius)))


class TabulatedSkin:
    """The skin of one press in the tabulated world."""

    def __init__(self, world: TabulatedWorld, pressing: Pressing) -> None:
        camera, centre_mm = pressing.camera, pressing.centre_mm
        pin_length_mm = camera.sensor.pin_length_mm
        fits = camera.sensor.dome_radius_mm in (None, OUTER_RADIUS_MM) or world.tables not in _SHIPPED
        if pin_length_mm is None or not fits:
            raise SettingError(
                "camera.sensor", wanted=f"pin_length_mm, on a dome of {OUTER_RADIUS_MM:g} mm or with tables of its own",
                found=repr(camera.sensor), do="Give the sensor that is simulated.",
            )  # fmt: skip
        self._scale = scale = dome_scale(camera)
        "Millimetres of the sensor in one of the tables, whose dome is of 20 mm."
        height_mm = pressing.specimen_height_mm
        self._library, self._radius_factor = tabulated(world.tables), math.sqrt(pressing.area_factor)
        solution = world.solution(pressing.stiffness_n_per_mm, height_mm and height_mm / scale)
        force_n, self._edge_mm, self._motion = solution
        self._log_force, self._log_radius = np.log(force_n), np.log(self._library.radius_mm)
        self._view = DomeView(
            focal_px=(camera.fx_px, camera.fy_px), pole_px=(camera.cx_px, camera.cy_px),
            depth_mm=camera.depth_mm / scale, pin_length_mm=pin_length_mm / scale,
        )  # fmt: skip
        x = math.radians(pressing.angle_deg) + centre_mm[0] / (scale * OUTER_RADIUS_MM)
        y = centre_mm[1] / (scale * OUTER_RADIUS_MM)
        self._axis = np.array([math.sin(x) * math.cos(y), math.sin(y), math.cos(x) * math.cos(y)])
        self._climbs = np.array([math.cos(x), 0.0, -math.sin(x)])
        self._newest: tuple[Points, PinsAroundAxis] | None = None
        "Points at rest that were last asked for: those of one press are the same in every frame."
        self._first = self.state(pressing.start_n)

    def state(self, force_n: float) -> ContactState:
        """State of a contact under a normal force, N."""
        radius_mm = self._scale * _radius(self._log_force, self._log_radius, force_n)
        return ContactState(radius_mm=self._radius_factor * radius_mm, normal_n=force_n)

    def area_mm2(self, state: ContactState) -> float:
        """Area of the contact, mm2."""
        return math.pi * state.radius_mm**2

    def contact(self, state: ContactState) -> ContactEllipse:
        outline = self._ring_px(self._edge_at(state), state)
        low, high = outline.min(axis=0), outline.max(axis=0)
        middle, half = (low + high) / 2, (high - low) / 2
        return ContactEllipse((float(middle[0]), float(middle[1])), (float(half[0]), float(half[1])))

    def moved_px(self, rest_px: Points, state: ContactState) -> Points:
        """Places (n, 2), px, of pins that are at ``rest_px`` (n, 2) at rest."""
        if state.normal_n <= 0 or not rest_px.size:
            return rest_px
        return np.asarray(rest_px + self._moved(self._around(rest_px), state))

    texture_px = moved_px

    def _around(self, rest_px: Points) -> PinsAroundAxis:
        if self._newest is None or self._newest[0] is not rest_px:
            self._newest = rest_px, self._view.around(self._view.directions(rest_px), self._axis)
        return self._newest[1]

    def skin_growth(self, before: ContactState, after: ContactState) -> float:
        arc_mm = self._edge_at(self._first)
        areas = [_area(self._ring_px(arc_mm, state)) for state in (before, after)]
        return math.log(areas[1] / areas[0])

    def _edge_at(self, state: ContactState) -> float:
        radius, of_state = self._library.radius_mm, state.radius_mm / self._scale
        return float(np.interp(of_state, radius, self._edge_mm) * min(of_state / radius[0], 1.0))

    def _ring_px(self, arc_mm: float, state: ContactState) -> Points:
        turn = np.linspace(0, 2 * np.pi, _OUTLINE, endpoint=False)
        across = np.linalg.svd(self._axis[None])[2][1:]
        around = np.cos(turn)[:, None] * across[0] + np.sin(turn)[:, None] * across[1]
        angle = arc_mm / INNER_RADIUS_MM
        directions = math.cos(angle) * self._axis + math.sin(angle) * around
        return self._view.rest_px(directions) + self._moved(self._view.around(directions, self._axis), state)

    def _moved(self, around: PinsAroundAxis, state: ContactState) -> Points:
        radius, of_state = self._library.radius_mm, state.radius_mm / self._scale
        low = int(np.clip(np.searchsorted(radius, of_state) - 1, 0, radius.size - 2))
        share = min((of_state - radius[low]) / (radius[low + 1] - radius[low]), 1.0)
        if share < 0:  # smaller than the first table: as much less as the contact is
            motion = self._motion[0] * (of_state / radius[0])
        else:
            motion = (1 - share) * self._motion[low] + share * self._motion[low + 1]
        arc_mm = self._library.arc_mm
        across, along, tilt = (np.interp(around.arc_mm, arc_mm, motion[:, k]) for k in range(3))
        if not state.tangential_mm:
            return around.moved_px(across, along, tilt)
        edge_mm = self._edge_at(state)
        pulled_mm = state.tangential_mm / self._scale * share_pulled(around.arc_mm, edge_mm, arc_mm[-1])
        return around.moved_px(across, along, tilt, pulled_mm[:, None] * self._climbs)


def _area(outline_px: Points) -> float:
    x, y = outline_px.T
    return abs(float(x @ np.roll(y, -1) - y @ np.roll(x, -1))) / 2
