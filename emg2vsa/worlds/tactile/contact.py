"""The world in which a contact sticks and then stretches: an elastic dome on a specimen of known stiffness."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from casr.errors import SettingError
from emg2vsa.dome_contact import ElasticDome
from emg2vsa.worlds.tactile.motion import lever, sheared, spread
from emg2vsa.worlds.tactile.region import ContactEllipse, Points, Rim, rim_distance
from emg2vsa.worlds.tactile.world import ContactState, Pressing


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
        if self.lever_ratio >= 1 or self.exponent > 1:
            raise SettingError(
                "lever_ratio, exponent",
                wanted="a ratio below 1 and an exponent of at most 1",
                found=f"{self.lever_ratio!r}, {self.exponent!r}",
                do="Correct the contact.",
            )

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
        """Contact radius a = R (3F / (4 E* R^2))^exponent, mm; 0 where the force does not press."""
        force = np.maximum(np.asarray(force_n, dtype=np.float64), 0.0)
        pressure_mpa = 4 * self.modulus_mpa(stiffness_n_per_mm) * self.tip_radius_mm**2 / 3
        return np.asarray(self.tip_radius_mm * (force / pressure_mpa) ** self.exponent, dtype=np.float64)

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
        self._radius_factor = math.sqrt(pressing.area_factor)
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
        return self._radius_factor * float(self._world.radius_mm(force_n, self._pressing.stiffness_n_per_mm))

    def _inside_rim(self, peak_n: float) -> float:
        """The largest radius, mm: it leaves ``RIM_GAP_PX`` along every ray."""
        radius_mm = self._radius_mm(peak_n)
        peak = self.contact(ContactState(radius_mm, peak_n))
        if peak.gap_px(self._rim) < RIM_GAP_PX:
            raise SettingError(
                "press",
                wanted=f"a contact that stays {RIM_GAP_PX:g} px inside the rim",
                found=f"{peak.gap_px(self._rim):.1f} px at {peak_n:g} N",
                do="Press less hard, less tilted or a stiffer specimen.",
            )
        to_edge = peak.polygon_px() - self._centre_px
        to_rim = rim_distance(to_edge, peak, self._rim) - RIM_GAP_PX
        return radius_mm * float((to_rim / np.hypot(*to_edge.T)).min())

    def contact(self, state: ContactState) -> ContactEllipse:
        x_mm, y_mm = self._pressing.camera.mm_per_px
        return ContactEllipse(self._centre_px, (state.radius_mm * self._cos / x_mm, state.radius_mm / y_mm))

    def area_mm2(self, state: ContactState) -> float:
        return self.contact(state).area_px2 * self._pressing.camera.mm2_per_px2

    def moved_px(self, rest_px: Points, state: ContactState) -> Points:
        if state.normal_n <= 0:
            return rest_px
        touch = self.contact(min(state, self._stuck, key=lambda each: each.radius_mm))
        return self.texture_px(lever(rest_px, touch, self._rim, self._world.lever_ratio), state)

    def texture_px(self, points_px: Points, state: ContactState) -> Points:
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
        share = sheared(depth, (rim_px - distance) / (rim_px - edge_px))
        along_px = state.tangential_mm * self._cos / self._pressing.camera.mm_per_px[0]
        return np.asarray(share[:, None] * (along_px, 0.0))

    def skin_growth(self, before: ContactState, after: ContactState) -> float:
        first, last = (max(each.radius_mm, self._stuck.radius_mm) for each in (before, after))
        return 2 * float(np.log(last / first))
