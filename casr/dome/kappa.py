"""Kappa of a specimen, N/mm: its stiffness under what pressed it (docs/method.md).

At small depth each way has a length, mm, of which kappa is the product with Young's modulus, MPa; kappa by one way over
that by another is the ratio of their lengths. Under a punch of 10 mm radius on a block of 35 x 25 mm, which tables of
domes are called by, the length is ``casr.dome.solver.punch.punch_on_block_mm``: it is solved for.
"""

from __future__ import annotations

import math

PUNCH_MM = 10.0
"Radius of the rigid flat punch without friction."
_RIM = 1.37
"Share of the height; found by finite elements of layers of 2 and 3 mm, which follow this law to 1 %."


def punch_on_half_space_mm(punch_mm: float, poisson: float = 0.0) -> float:
    """Rigid flat punch without friction (Sneddon 1965). Without Poisson's ratio it goes with the reduced modulus."""
    return 2 * punch_mm / (1 - poisson**2)


def plate_on_cylinder_mm(radius_mm: float, height_mm: float, *, bonded: bool = False) -> float:
    """Length kappa/E, mm, of a plate on the whole face of an incompressible cylinder, whose two ends slide or both
    cannot (Gent and Lindley 1959, Proceedings of the Institution of Mechanical Engineers 173, 111)."""
    stiffer = 1 + (radius_mm / height_mm) ** 2 / 2 if bonded else 1.0
    return math.pi * radius_mm**2 / height_mm * stiffer


def punch_on_thin_layer_mm(punch_mm: float, height_mm: float) -> float:
    """Length kappa/E, mm, of a punch without friction on an incompressible layer, bonded to a plate, far thinner than
    the punch is wide.

    Lubrication theory of the rubber that is squeezed outward: pressure 3 mu depth (a^2 - r^2) / (4 h^3), mu = E / 3.
    The rubber bulges beyond the rim, as under a punch that is wider.
    """
    return math.pi * (punch_mm + _RIM * height_mm) ** 4 / (8 * height_mm**3)
