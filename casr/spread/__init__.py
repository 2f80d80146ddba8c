"""From divergence to area, eq. (1), and from area and force to the contact area spread rate, eq. (2)."""

from casr.spread.area_law import AREA_LAWS, contact_areas
from casr.spread.power_law import PowerLaw
from casr.spread.rate import RATE_RULES, WINDOW_N, SpreadRate, readable, spread_rate
from casr.spread.total import TotalInterval, total_interval

__all__ = [
    "AREA_LAWS",
    "RATE_RULES",
    "WINDOW_N",
    "PowerLaw",
    "SpreadRate",
    "TotalInterval",
    "contact_areas",
    "readable",
    "spread_rate",
    "total_interval",
]
