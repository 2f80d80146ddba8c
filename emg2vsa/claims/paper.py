"""The numbers that the paper prints."""

from __future__ import annotations

import math

KAPPA_N_PER_MM = {"S1": 7.63, "S2": 5.32, "S3": 3.35, "S4": 3.12, "S5": 1.11}
"""Stiffness of its specimens by plate indentation, stiffest first."""

WEIGHT_ALPHA, INTERPOLATION_RMSE_V = 0.532, 0.0002
"""Weight of the softer neighbour in the profile of S_new, and RMSE of that profile beside the measured one."""
SCHEDULE_PERCENT, SCHEDULE_STEP_N = (20.0, 80.0), 0.3
FILTER_CUTOFF_HZ = 5.0
ANGLES_DEG = (0.0, 30.0, 45.0)
AREA_SPECIMENS_P = {0.0: 0.51, 30.0: 0.74, 45.0: 0.61}
"""Kruskal-Wallis of A_c0 between specimens."""
AREA_ANGLES_WORST_P = 3.1079e-05
CASR_WORST_P = {
    ("high-stiffness", 30.0): 0.0111,
    ("high-stiffness", 45.0): 0.0111,
    ("modular", 0.0): 0.0034,
    ("modular", 30.0): 0.0034,
    ("modular", 45.0): 0.0018,
    ("constant-min", 0.0): 0.0037,
    ("constant-mean", 0.0): 0.0018,
    ("constant-max", 0.0): 0.0018,
}
"""Between specimens; the rigid one is the worst of all its angles, that of 0° and 30° modular the worst of both."""
DESIGNS = frozenset(CASR_WORST_P)
"""Conditions and angles that section VI reports; the rigid motor at 0° is of the previous work."""
NEW_MIN_STIFFNESS_P = 0.3799
"""p of S_new against S1 at the lowest constant stiffness, the one condition that did not discriminate them."""
ERROR_OLD_VISION = {0.0: 0.06, 30.0: 0.25, 45.0: 0.28}
ERROR_NEW_VISION = {30.0: 0.07, 45.0: 0.13}
ERROR_HUMAN_LIKE = {0.0: 0.03, 30.0: 0.03, 45.0: 0.04}
"""Error of the stiffness of S_new by angle, sign not printed (Table I)."""
ERROR_CONSTANT = {"constant-max": 0.0472, "constant-mean": 0.05}
WORST_ADJ_R2 = {"high-stiffness": 0.8963, "modular": 0.9753, "constant-max": 0.9849, "constant-mean": 0.9996}
"""Adjusted R² of the exponential law, the worst over the angles of ``DESIGNS``."""
CURVES = {0.0: (10.21, -1.567), 30.0: (14.76, -23.94), 45.0: (8.639, -58.67)}
"""kappa = p exp(q CASR) of the human-like condition: p in N/mm, q per unit of CASR, which is not printed."""


def implied_casr(angle_deg: float, kappa_n_per_mm: float) -> float:
    """CASR at which the paper's curve of this angle gives that stiffness, in the unit that is not printed."""
    level, rate = CURVES[angle_deg]
    return math.log(kappa_n_per_mm / level) / rate


def implied_ratio(angle_deg: float) -> float:
    """CASR of the softest specimen over that of the stiffest, as the paper's curve of this angle, degrees, implies
    them."""
    stiffest, *_, softest = KAPPA_N_PER_MM.values()
    return implied_casr(angle_deg, softest) / implied_casr(angle_deg, stiffest)


def largest_ratio() -> float:
    """The largest such ratio that contact mechanics allows: (kappa_stiffest / kappa_softest)^(2/3).

    The contact of a dome grows as (F / E)^(2/3) (Hertz) with E of sensor and specimen in series, so that a rigid sensor
    has the largest ratio; stiffness by plate indentation is proportional to E.
    """
    stiffest, *_, softest = KAPPA_N_PER_MM.values()
    return math.cbrt(stiffest / softest) ** 2
