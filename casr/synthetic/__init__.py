"""Rendered presses with known flow, contact area and force."""
