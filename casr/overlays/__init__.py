"""Pictures of one press: pins, initial area, contact region, motion, area against force."""

from casr.overlays.canvas import Picture
from casr.overlays.press import press_pictures

__all__ = ["Picture", "press_pictures"]
