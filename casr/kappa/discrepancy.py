"""By how much a real sensor differs from the tables of domes, and its presses from each other."""

from __future__ import annotations

from dataclasses import dataclass, replace

USUAL_MISFIT = 0.02
"Share of the motion left over beyond noise; where there is more, the tables fit this sensor less well than each other."

MOUNTING_SD = 0.043
"Relative SD of CASR from mounting to mounting, that of the emulated bench."


@dataclass(frozen=True, kw_only=True)
class Discrepancy:
    """Standard deviations by which a real sensor differs from the family and presses from each other.

    level, slope : of the line by which labels z differ from the truth. curve : about the line, alike over ``curve_z``.
    scatter : of the label of a press. stiffness : relative, of a specimen from mounting to mounting.
    log_kappa0 : of a sensor's modulus, relative to that of the tables. log_force : of the tables' forces, all alike;
    force_curve : from specimen to specimen. force_mounting : of the force at a radius, from mounting to mounting of a
    specimen; force_scatter : from press to press.
    travel_curve, travel_mounting, travel_scatter : of 3/2 ln of travel per newton, in the same ways.
    freedom : degrees of freedom that these were found with.
    What mountings differ by, ``stiffness`` and ``*_mounting``, makes CASR differ by ``MOUNTING_SD``.
    """

    level: float = 0.03
    slope: float = 0.10
    curve: float = 0.0075
    curve_z: float = 0.15
    scatter: float = 0.002
    stiffness: float = 0.035
    log_kappa0: float = 1.0
    log_force: float = 0.05
    force_curve: float = 0.02
    force_mounting: float = 0.03
    force_scatter: float = 0.03
    travel_curve: float = 0.02
    travel_mounting: float = 0.04
    travel_scatter: float = 0.01
    freedom: float = 10.0

    def mounted(self, casr_sd: float) -> Discrepancy:
        """Discrepancy of mountings whose CASR has this relative SD."""
        names = ("stiffness", "force_mounting", "travel_mounting")
        return replace(self, **{name: casr_sd / MOUNTING_SD * getattr(self, name) for name in names})

    def scaled(self, factor: float) -> Discrepancy:
        """Discrepancy of a sensor that the tables fit less well."""
        names = ("level", "slope", "curve", "log_force", "force_curve")
        return replace(self, **{name: factor * getattr(self, name) for name in names})


EXACT = Discrepancy(level=1e-6, slope=1e-6, curve=1e-6, scatter=1e-6, stiffness=0.0)
"A sensor that is one of the family, and presses that differ by noise alone."
