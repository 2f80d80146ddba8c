"""What the camera of a sensor sees of a contact: stateless, so frames may be asked for in any order and in real time.

A contact is given as its state, or as the force of one without friction or history.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from emg2vsa.worlds.tactile.appearance import Surface, draw_surface
from emg2vsa.worlds.tactile.draws import Draws
from emg2vsa.worlds.tactile.region import ContactEllipse, Points, Rim
from emg2vsa.worlds.tactile.render import drawn, exposed
from emg2vsa.worlds.tactile.settings import PressSettings
from emg2vsa.worlds.tactile.world import ContactState, Pressing


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
        self.drawn = drawn = settings.drawn or settings.scatter.drawn(self.draws)
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
        self._still: tuple[ContactState, NDArray[np.float32]] | None = None
        "State and grey levels of the newest image, which off contact is many frames long the same."
        self.centre_px = self.skin.contact(self.skin.state(settings.timeline.start_n)).centre_px

    @cached_property
    def surface(self) -> Surface:
        """The look of this press."""
        s = self.settings
        return draw_surface(s.appearance, s.skin, s.camera, self.draws.sensor(), self.draws.of("brightness"))

    def contact(self, pressed: float | ContactState) -> ContactEllipse:
        """Contact in the image; a point at 0 N and below."""
        return self.skin.contact(self._state(pressed))

    def area_mm2(self, pressed: float | ContactState) -> float:
        """True area of the contact; 0 at 0 N and below."""
        return self.skin.area_mm2(self._state(pressed))

    def pins_px(self, pressed: float | ContactState) -> Points:
        """(n_pins, 2) pin tips, those of missing pins too."""
        return self.skin.moved_px(self.rest_px, self._state(pressed))

    def image(self, pressed: float | ContactState, frame: int) -> NDArray[np.uint8]:
        """(H, W) frame number ``frame`` of that contact; the number chooses the noise only."""
        state, still = self._state(pressed), self._still
        if still is None or still[0] != state:
            texture_px = self.surface.speckle_px
            moved_px = self.skin.texture_px(texture_px, state) if texture_px.size else texture_px
            still = self._still = state, drawn(self.pins_px(state), self.surface, self.settings.skin, moved_px)
        return exposed(still[1], self.settings.appearance.noise_grey, self.draws.of("frame", frame))

    def skin_growth(self, before_n: float, after_n: float) -> float:
        """ln of how much larger the skin of the first contact becomes in the image between two forces."""
        return self.skin.skin_growth(self._state(before_n), self._state(after_n))

    def _state(self, pressed: float | ContactState) -> ContactState:
        return pressed if isinstance(pressed, ContactState) else self.skin.state(max(pressed, 0.0))

    def _landing_mm(self) -> tuple[float, float]:
        """How far from where it was meant to the contact lands."""
        x, y = np.clip(self.draws.of("centre").standard_normal(2), -2, 2) * self.settings.centre_sd_mm
        return float(x), float(y)
