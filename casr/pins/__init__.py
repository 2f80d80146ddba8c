"""Pins of the tactile skin: sub-pixel detection, one-to-one matching, tracking from frame to frame."""

from casr.pins.detect import Pins, detect_pins
from casr.pins.lattice import match_pins, pin_pitch_px, pins_in_doubt
from casr.pins.track import PinTracker
from casr.pins.view import PinSettings

__all__ = ["PinSettings", "PinTracker", "Pins", "detect_pins", "match_pins", "pin_pitch_px", "pins_in_doubt"]
