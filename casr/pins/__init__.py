"""Pins of the tactile skin: sub-pixel detection, one-to-one matching, tracking from frame to frame."""
