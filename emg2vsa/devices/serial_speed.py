"""Speeds of the serial line to the actuator's boards; light, as the command line offers them."""

from __future__ import annotations

from typing import Literal

Baud = Literal[2_000_000, 460_800]
"""Of the serial line: that of generations 6 and 7, and that of generation 5 and of whoever sets it (SET_BAUDRATE)."""
BAUD: Baud = 2_000_000
