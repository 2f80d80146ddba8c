"""What the camera of a sensor sees at a force: stateless, so frames may be asked for in any order and in real time."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from casr.synthetic.appearance import Surface, draw_surface
from casr.synthetic.draws import Draws
from casr.synthetic.region import ContactEllipse, Points, Rim
from casr.synthetic.render import drawn, exposed
from casr.synthetic.settings import PressSettings
from casr.synthetic.world import Pressing


class Scene:
    """Sensor, specimen and contact of one press.

    Parameters
    ----------
    settings : the press, as it was meant; ``drawn`` is in what it differs.

    Raises
    ------
    SettingError : the world has no such contact at ``peak_n``.
    """

    def __init__(self, settings: PressSettings) -> None:
        self.settings = settings
        self.draws = Draws(
            settings.seed, settings.stiffness_n_per_mm, settings.angle_deg, settings.repetition, settings.mounting
        )
        self.drawn = drawn = settings.scatter.drawn(self.draws)
        camera = settings.camera
        self.rim = Rim((camera.cx_px, camera.cy_px), settings.skin.mask_radius_px)
        self.rest_px = settings.skin.pins_px(self.rim.centre_px)
        pressing = Pressing(
            stiffness_n_per_mm=settings.stiffness_n_per_mm * drawn.stiffness,
            angle_deg=abs(settings.angle_deg + drawn.angle_deg),
            centre_mm=self._landing_mm(),
            camera=replace(camera, depth_mm=camera.depth_mm * drawn.depth),
            mask_radius_px=settings.skin.mask_radius_px,
            start_n=settings.timeline.start_n,
            peak_n=settings.timeline.peak_n,
            area_factor=drawn.area,
        )
        self.skin = settings.world.press(pressing)
        self._still: tuple[float, NDArray[np.float32]] | None = None
        "Force and grey levels of the newest image, which off contact is many frames long the same."
        self.centre_px = self.skin.contact(self.skin.state(settings.timeline.start_n)).centre_px

    @cached_property
    def surface(self) -> Surface:
        """The look of this press."""
        s = self.settings
        return draw_surface(s.appearance, s.skin, s.camera, self.draws.sensor(), self.draws.of("brightness"))

    def contact(self, force_n: float) -> ContactEllipse:
        """Contact in the image; a point at 0 N and below."""
        return self.skin.contact(self.skin.state(max(force_n, 0.0)))

    def area_mm2(self, force_n: float) -> float:
        """True area of the contact; 0 at 0 N and below."""
        return self.skin.area_mm2(self.skin.state(max(force_n, 0.0)))

    def pins_px(self, force_n: float) -> Points:
        """(n_pins, 2) pin tips, those of missing pins too."""
        return self.skin.moved_px(self.rest_px, self.skin.state(max(force_n, 0.0)))

    def image(self, force_n: float, frame: int) -> NDArray[np.uint8]:
        """(H, W) frame number ``frame``, taken at ``force_n``; the number chooses the noise only."""
        still = self._still
        if still is None or still[0] != force_n:
            grey = drawn(self.pins_px(force_n), self.surface, self.settings.skin, self._texture_px(force_n))
            still = self._still = force_n, grey
        return exposed(still[1], self.settings.appearance.noise_grey, self.draws.of("frame", frame))

    def skin_growth(self, before_n: float, after_n: float) -> float:
        """ln of how much larger the skin of the first contact becomes in the image between two forces."""
        return self.skin.skin_growth(*(self.skin.state(max(force, 0.0)) for force in (before_n, after_n)))

    def _texture_px(self, force_n: float) -> Points:
        texture_px = self.surface.speckle_px
        return self.skin.texture_px(texture_px, self.skin.state(max(force_n, 0.0))) if texture_px.size else texture_px

    def _landing_mm(self) -> tuple[float, float]:
        """How far from where it was meant to the contact lands."""
        x, y = np.clip(self.draws.of("centre").standard_normal(2), -2, 2) * self.settings.centre_sd_mm
        return float(x), float(y)
