"""Pictures of presses; loaded when they are first asked for."""

from typing import TYPE_CHECKING

from casr.lazy_names import lazy_names

if TYPE_CHECKING:
    from casr.overlays.frames import area_picture, pins_picture
    from casr.overlays.press import followed_picture, press_pictures

_NAMES = {"area_picture": "frames", "followed_picture": "press", "pins_picture": "frames", "press_pictures": "press"}
__all__ = ["area_picture", "followed_picture", "pins_picture", "press_pictures"]

__getattr__, __dir__ = lazy_names(__name__, _NAMES)
