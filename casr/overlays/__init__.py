"""Pictures of one press: pins, initial area, contact region, motion, area against force."""

from casr.overlays.area import area_picture, pins_picture
from casr.overlays.canvas import Picture
from casr.overlays.motion import flow_picture, spreading_picture
from casr.overlays.press import pin_ways, press_pictures

__all__ = [
    "Picture", "area_picture", "flow_picture", "pin_ways", "pins_picture", "press_pictures", "spreading_picture",
]  # fmt: skip
