"""The skin of the world in which a contact sticks and then stretches: ``ContactWorld``."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from casr.errors import SettingError
from casr.synthetic.motion import lever, spread
from casr.synthetic.region import ContactEllipse, Points, Rim, rim_distance
from casr.synthetic.world import ContactState

if TYPE_CHECKING:
    from casr.synthetic.contact import ContactWorld
    from casr.synthetic.settings import PressSettings


RIM_GAP_PX = 2.0
"Room left between contact and rim; a harder press grows the contact no further."


class StickSkin:
    """Up to ``stick_force_n`` the front advances over resting skin and pins tilt; then the contact is a piece of skin.

    Areas are those seen in the image plane, so that a tilt of the sensor takes its cosine.
    """

    def __init__(
        self, world: ContactWorld, settings: PressSettings, centre_mm: tuple[float, float], area_factor: float
    ) -> None:
        self._world, self._settings, self._radius_factor = world, settings, math.sqrt(area_factor)
        camera = settings.camera
        self._rim = Rim((camera.cx_px, camera.cy_px), settings.skin.mask_radius_px)
        self._cos = math.cos(math.radians(settings.angle_deg))
        # pins at the contact's middle stand along the normal, so their tips show (R - pin length) sin(angle)
        tips_mm = world.tip_radius_mm * (1 - world.lever_ratio)
        x_mm = centre_mm[0] + tips_mm * math.sin(math.radians(settings.angle_deg))
        mm_per_px = camera.mm_per_px
        self._centre_px = (camera.cx_px + x_mm / mm_per_px[0], camera.cy_px + centre_mm[1] / mm_per_px[1])
        self._largest_mm = self._inside_rim(settings.timeline.peak_n)
        self._stuck = self.state(world.stick_force_n)

    def state(self, force_n: float) -> ContactState:
        """A press harder than that of the largest contact which leaves room to the rim grows it no further."""
        return ContactState(radius_mm=min(self._radius_mm(force_n), self._largest_mm), normal_n=force_n)

    def _radius_mm(self, force_n: float) -> float:
        return self._radius_factor * float(self._world.radius_mm(force_n, self._settings.stiffness_n_per_mm))

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
        x_mm, y_mm = self._settings.camera.mm_per_px
        return ContactEllipse(self._centre_px, (state.radius_mm * self._cos / x_mm, state.radius_mm / y_mm))

    def area_mm2(self, state: ContactState) -> float:
        return self.contact(state).area_px2 * self._settings.camera.mm2_per_px2

    def moved_px(self, rest_px: Points, state: ContactState) -> Points:
        if state.normal_n <= 0:
            return rest_px
        touch = self.contact(min(state, self._stuck, key=lambda each: each.radius_mm))
        return self.texture_px(lever(rest_px, touch, self._rim, self._world.lever_ratio), state)

    def texture_px(self, points_px: Points, state: ContactState) -> Points:
        if state.radius_mm <= self._stuck.radius_mm or not points_px.size:
            return points_px
        return spread(points_px, self.contact(self._stuck), self.contact(state), self._rim)

    def skin_growth(self, before: ContactState, after: ContactState) -> float:
        first, last = (max(each.radius_mm, self._stuck.radius_mm) for each in (before, after))
        return 2 * float(np.log(last / first))
