"""What the camera of a sensor sees at a force: stateless, so frames may be asked for in any order and in real time."""

from __future__ import annotations

import math
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from casr.errors import SettingError
from casr.synthetic.appearance import Surface, draw_surface
from casr.synthetic.draws import Draws
from casr.synthetic.motion import lever, spread, true_divergence
from casr.synthetic.region import ContactEllipse, Points, Rim, rim_distance
from casr.synthetic.render import render
from casr.synthetic.settings import PressSettings

RIM_GAP_PX = 2.0
"Room left between contact and rim; a harder press grows the contact no further."


class Scene:
    """Sensor, specimen and contact of one press.

    Parameters
    ----------
    settings : the press.

    Raises
    ------
    SettingError : at ``peak_n`` the contact would reach the rim of the image.
    """

    def __init__(self, settings: PressSettings) -> None:
        self.settings = settings
        self.draws = Draws(settings.seed, settings.stiffness_n_per_mm, settings.angle_deg, settings.repetition)
        camera = settings.camera
        self.rim = Rim((camera.cx_px, camera.cy_px), settings.skin.mask_radius_px)
        self.rest_px = settings.skin.pins_px(self.rim.centre_px)
        self.centre_px = self._landing()
        peak = self._ellipse(settings.timeline.peak_n)
        if peak.gap_px(self.rim) < RIM_GAP_PX:
            raise SettingError(
                "press",
                wanted=f"a contact that stays {RIM_GAP_PX:g} px inside the rim",
                found=f"{peak.gap_px(self.rim):.1f} px at {settings.timeline.peak_n:g} N",
                do="Press less hard, less tilted or a stiffer specimen.",
            )

    @cached_property
    def surface(self) -> Surface:
        """The look of this press."""
        s = self.settings
        return draw_surface(s.appearance, s.skin, s.camera, self.draws.sensor(), self.draws.of("brightness"))

    def contact(self, force_n: float) -> ContactEllipse:
        """Contact in the image; a point at 0 N and below."""
        return self._ellipse(min(force_n, self._largest_force_n))

    def pins_px(self, force_n: float) -> Points:
        """(n_pins, 2) pin tips, those of missing pins too."""
        if force_n <= 0:
            return self.rest_px
        world = self.settings.world
        touch = self.contact(min(force_n, world.stick_force_n))
        return self._stretched(lever(self.rest_px, touch, self.rim, world.lever_ratio), force_n)

    def image(self, force_n: float, frame: int) -> NDArray[np.uint8]:
        """(H, W) frame number ``frame``, taken at ``force_n``; the number chooses the noise only."""
        return render(
            self.pins_px(force_n),
            self.surface,
            self.settings.skin,
            speckle_px=self._stretched(self.surface.speckle_px, force_n),
            noise_grey=self.settings.appearance.noise_grey,
            rng=self.draws.of("frame", frame),
        )

    def divergence(self, before_n: float, after_n: float) -> float:
        """True divergence inside the contact between two forces, both from ``stick_force_n`` on, per frame pair."""
        return true_divergence(*self._sticking(before_n, after_n))

    def _stretched(self, points_px: Points, force_n: float) -> Points:
        stick_n = self.settings.world.stick_force_n
        if force_n <= stick_n or not points_px.size:
            return points_px
        return spread(points_px, self.contact(stick_n), self.contact(force_n), self.rim)

    def _sticking(self, *forces_n: float) -> tuple[ContactEllipse, ContactEllipse]:
        least = self.settings.world.stick_force_n
        if min(forces_n) < least:
            raise SettingError(
                "force_n",
                wanted=f"{least:g} N or more: below it pins tilt and the skin has no flow",
                found=f"{min(forces_n):g} N",
                do="Ask for frames of the loading phase.",
            )
        before, after = (self.contact(force) for force in forces_n)
        return before, after

    def _ellipse(self, force_n: float) -> ContactEllipse:
        s = self.settings
        radius_mm = float(s.world.radius_mm(force_n, s.stiffness_n_per_mm))
        x_mm, y_mm = s.camera.mm_per_px
        return ContactEllipse(
            self.centre_px, (radius_mm * math.cos(math.radians(s.angle_deg)) / x_mm, radius_mm / y_mm)
        )

    def _landing(self) -> tuple[float, float]:
        """Contact centre: pins there stand along the normal, so their tips show (R - pin length) sin(angle)."""
        s = self.settings
        offset_mm = np.clip(self.draws.of("centre").standard_normal(2), -2, 2) * s.centre_sd_mm
        tips_mm = s.world.tip_radius_mm * (1 - s.world.lever_ratio)
        x_mm, y_mm = offset_mm[0] + tips_mm * math.sin(math.radians(s.angle_deg)), offset_mm[1]
        mm_per_px = s.camera.mm_per_px
        return float(s.camera.cx_px + x_mm / mm_per_px[0]), float(s.camera.cy_px + y_mm / mm_per_px[1])

    @cached_property
    def _largest_force_n(self) -> float:
        """Force whose contact leaves ``RIM_GAP_PX`` along every ray."""
        s = self.settings
        peak = self._ellipse(s.timeline.peak_n)
        to_edge = peak.polygon_px() - self.centre_px
        to_rim = rim_distance(to_edge, peak, self.rim) - RIM_GAP_PX
        growth = float((to_rim / np.hypot(*to_edge.T)).min())
        return float(s.timeline.peak_n * growth ** (1 / s.world.exponent))
