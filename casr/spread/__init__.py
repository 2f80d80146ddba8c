"""From divergence to area, eq. (1), and from area and force to the contact area spread rate, eq. (2)."""

from casr.spread.area_law import AREA_LAWS, contact_areas
from casr.spread.curves import PowerLaw, fit_power_laws
from casr.spread.intervals import TotalInterval, total_interval
from casr.spread.rate import RATE_RULES, WINDOW_N, SpreadRate, readable, spread_rate, spread_rates

__all__ = [
    "AREA_LAWS", "RATE_RULES", "WINDOW_N", "PowerLaw", "SpreadRate", "TotalInterval", "contact_areas",
    "fit_power_laws", "readable", "spread_rate", "spread_rates", "total_interval",
]  # fmt: skip
