"""The world in which a contact sticks and then stretches: an elastic dome on a specimen of known stiffness.

Pins lever outward at first contact, then the contact stretches the skin along rays from its centre.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from casr.dome.pull import share_pulled
from emg2vsa.dome_contact import ElasticDome
from emg2vsa.worlds.tactile.world import (
    ContactEllipse,
    ContactState,
    Points,
    Pressing,
    Rim,
    check,
    rim_distance,
)


@dataclass(frozen=True, kw_only=True)
class ContactWorld(ElasticDome):
    """Mechanics of sensor and specimen.

    Parameters
    ----------
    lever_ratio : length of a pin over the radius of the dome (guess).
    stick_force_n : up to this force the contact grows over the resting skin and pins only tilt; from it on the contact
        is a piece of skin that stretches (guess). It lies below the first contact of 0.5 N by the force gained in half
        a frame: the log rows of a frame are written after its exposure, so the frame whose rows first average 0.5 N
        may have been exposed at 0.44 N, and the area law is to hold from there.
    """

    lever_ratio: float = 0.1
    stick_force_n: float = 0.43

    def __post_init__(self) -> None:
        super().__post_init__()
        check(
            self.lever_ratio < 1 and self.exponent <= 1, "lever_ratio, exponent",
            "a ratio below 1 and an exponent of at most 1", f"{self.lever_ratio!r}, {self.exponent!r}",
            "Correct the contact.",
        )  # fmt: skip

    @property
    def name(self) -> str:
        """In results."""
        return f"stick from {self.stick_force_n:g} N"

    @property
    def assumptions(self) -> tuple[str, ...]:
        """What is not known to be so."""
        return ("from stick_force_n on the contact is a piece of skin that stretches as the contact grows",)

    def press(self, pressing: Pressing) -> StickSkin:
        """The skin of one press."""
        return StickSkin(self, pressing)

    def radius_mm(self, force_n: ArrayLike, stiffness_n_per_mm: float) -> NDArray[np.float64]:
        """Contact radius, mm, by `PowerLaw`, at forces, N, of any shape (scalar or not); 0 where the force does not
        press."""
        return self.on(stiffness_n_per_mm).radius_mm(force_n)

    def area_mm2(self, force_n: ArrayLike, stiffness_n_per_mm: float, angle_deg: float = 0.0) -> NDArray[np.float64]:
        """Contact area in the image plane, pi a^2 cos(angle), mm^2."""
        return np.pi * self.radius_mm(force_n, stiffness_n_per_mm) ** 2 * math.cos(math.radians(angle_deg))


RIM_GAP_PX = 2.0
"Room left between contact and rim; a harder press grows the contact no further."


class StickSkin:
    """Up to ``stick_force_n`` the front advances over resting skin and pins tilt; then the contact is a piece of skin.

    Areas are those seen in the image plane, so that a tilt of the sensor takes its cosine.
    """

    def __init__(self, world: ContactWorld, pressing: Pressing) -> None:
        self._world, self._pressing = world, pressing
        self._radius_factor, self._law = math.sqrt(pressing.area_factor), world.on(pressing.stiffness_n_per_mm)
        camera, centre_mm = pressing.camera, pressing.centre_mm
        self._rim = Rim((camera.cx_px, camera.cy_px), pressing.mask_radius_px)
        self._cos = math.cos(math.radians(pressing.angle_deg))
        # pins at the contact's middle stand along the normal, so their tips show (R - pin length) sin(angle)
        tips_mm = world.tip_radius_mm * (1 - world.lever_ratio)
        x_mm = centre_mm[0] + tips_mm * math.sin(math.radians(pressing.angle_deg))
        mm_per_px = camera.mm_per_px
        self._centre_px = (camera.cx_px + x_mm / mm_per_px[0], camera.cy_px + centre_mm[1] / mm_per_px[1])
        self._largest_mm = self._inside_rim(pressing.peak_n)
        self._stuck = self.state(world.stick_force_n)

    def state(self, force_n: float) -> ContactState:
        """A press harder than that of the largest contact which leaves room to the rim grows it no further."""
        return ContactState(radius_mm=min(self._radius_mm(force_n), self._largest_mm), normal_n=force_n)

    def _radius_mm(self, force_n: float) -> float:
        return self._radius_factor * float(self._law.radius_mm(force_n))

    def _inside_rim(self, peak_n: float) -> float:
        """The largest radius, mm: it leaves ``RIM_GAP_PX`` along every ray."""
        radius_mm = self._radius_mm(peak_n)
        peak = self.contact(ContactState(radius_mm, peak_n))
        gap_px, do = peak.gap_px(self._rim), "Press less hard, less tilted or a stiffer specimen."
        wanted = f"a contact that stays {RIM_GAP_PX:g} px inside the rim"
        check(gap_px >= RIM_GAP_PX, "press", wanted, f"{gap_px:.1f} px at {peak_n:g} N", do)
        to_edge = peak.polygon_px() - self._centre_px
        to_rim = rim_distance(to_edge, peak, self._rim) - RIM_GAP_PX
        return radius_mm * float((to_rim / np.hypot(*to_edge.T)).min())

    def contact(self, state: ContactState) -> ContactEllipse:
        x_mm, y_mm = self._pressing.camera.mm_per_px
        return ContactEllipse(self._centre_px, (state.radius_mm * self._cos / x_mm, state.radius_mm / y_mm))

    def area_mm2(self, state: ContactState) -> float:
        """Area of the contact, mm2, as seen in the image plane."""
        return self.contact(state).area_px2 * self._pressing.camera.mm2_per_px2

    def moved_px(self, rest_px: Points, state: ContactState) -> Points:
        """Places (n, 2), px, of pins that are at ``rest_px`` (n, 2) at rest."""
        if state.normal_n <= 0:
            return rest_px
        touch = self.contact(min(state, self._stuck, key=lambda each: each.radius_mm))
        return self.texture_px(lever(rest_px, touch, self._rim, self._world.lever_ratio), state)

    def texture_px(self, points_px: Points, state: ContactState) -> Points:
        """Places (n, 2), px, of points of the skin, which do not lever as pins do."""
        grown_px = self._grown_px(points_px, state)
        if state.normal_n > 0 and state.tangential_mm and points_px.size:
            return grown_px + self._pulled_px(grown_px, state)
        return grown_px

    def _grown_px(self, points_px: Points, state: ContactState) -> Points:
        if state.radius_mm <= self._stuck.radius_mm or not points_px.size:
            return points_px
        return spread(points_px, self.contact(self._stuck), self.contact(state), self._rim)

    def _pulled_px(self, points_px: Points, state: ContactState) -> Points:
        """(N, 2) how far friction pulls the skin that would be at these points."""
        contact = self.contact(state)
        from_centre, depth = points_px - contact.centre_px, contact.depth(points_px)
        distance = np.hypot(*from_centre.T)
        edge_px, rim_px = distance / np.maximum(depth, 1e-9), rim_distance(from_centre, contact, self._rim)
        share = share_pulled(distance, edge_px, rim_px)
        along_px = state.tangential_mm * self._cos / self._pressing.camera.mm_per_px[0]
        return np.asarray(share[:, None] * (along_px, 0.0))

    def skin_growth(self, before: ContactState, after: ContactState) -> float:
        first, last = (max(each.radius_mm, self._stuck.radius_mm) for each in (before, after))
        return 2 * float(np.log(last / first))


def lever(rest_px: Points, contact: ContactEllipse, rim: Rim, ratio: float) -> Points:
    """Pin tips where the dome is flattened over ``contact``.

    A pin of length ``ratio`` R stands square on the skin, so its tip goes outward by ``ratio`` R times the change of
    slope of the surface: r/R inside the contact, (2/(pi R)) (r asin(a/r) - a sqrt(1 - a^2/r^2)) outside (Hertz; Johnson
    1985, section 3.4), with r on the skin. At rest tips lean inward and show r (1 - ratio); inside the contact they are
    parallel and show r itself. Outside the displacement also fades, to nothing at the rim.

    Parameters
    ----------
    rest_px : (N, 2) tips at rest.

    Returns
    -------
    (N, 2) tips in contact.
    """
    from_centre = np.asarray(rest_px) - contact.centre_px
    depth = contact.depth(rest_px) / (1 - ratio)
    outside = depth > 1
    inverse = 1 / np.where(outside, depth, 1.0)
    levelled = (2 / np.pi) * (np.arcsin(inverse) - inverse * np.sqrt(1 - inverse**2))
    distance = np.hypot(from_centre[..., 0], from_centre[..., 1])
    rim_px = rim_distance(from_centre, contact, rim)
    fade = np.clip((rim_px - distance) / (rim_px - distance * inverse), 0.0, 1.0)
    gain = np.where(outside, levelled * fade, 1.0) * ratio / (1 - ratio)
    return np.asarray(rest_px + from_centre * gain[..., None])


def spread(points_px: Points, before: ContactEllipse, after: ContactEllipse, rim: Rim) -> Points:
    """Points of the skin after the contact, a piece of skin, grew from ``before`` to ``after``.

    Along each ray from the centre, with b the edge before, s b the edge after and m the rim, a distance rho becomes
    s rho inside. Outside, the skin between edge and rim is squeezed evenly, m - rho' = (m - rho) (m - s b) / (m - b),
    and the rim rests. Maps compose exactly, and the inverse is the map with the contacts exchanged. (A squeeze of equal
    areas, m^2 - rho^2 in place of m - rho, crowds pins just outside the edge until they merge.)

    Parameters
    ----------
    points_px : (..., 2) points; those at or beyond the rim stay.
    before, after : contacts of one centre and one shape, inside the rim.
    """
    stretch = after.semi_axes_px[0] / before.semi_axes_px[0]
    from_centre = np.asarray(points_px, dtype=np.float64) - before.centre_px
    depth = before.depth(points_px)
    outside = depth > 1
    distance = np.where(outside, np.hypot(from_centre[..., 0], from_centre[..., 1]), 1.0)
    edge = distance / np.where(outside, depth, 1.0)
    rim_px = rim_distance(from_centre, before, rim)
    moved = rim_px - (rim_px - distance) * (rim_px - stretch * edge) / (rim_px - edge)
    gain = np.where(outside, np.where(distance < rim_px, moved / distance, 1.0), stretch)
    return np.asarray(before.centre_px + from_centre * gain[..., None])
