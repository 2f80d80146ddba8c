"""The numbers that the paper prints in section VI."""

from __future__ import annotations

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
"""Of S_new against S1 at the lowest constant stiffness: the one condition that did not discriminate it."""
ERROR_OLD_VISION = {0.0: 0.06, 30.0: 0.25, 45.0: 0.28}
ERROR_NEW_VISION = {30.0: 0.07, 45.0: 0.13}
ERROR_HUMAN_LIKE = {0.0: 0.03, 30.0: 0.03, 45.0: 0.04}
"""On the stiffness of S_new, sign not printed (Table I)."""
ERROR_CONSTANT = {"constant-max": 0.0472, "constant-mean": 0.05}
WORST_ADJ_R2 = {"high-stiffness": 0.8963, "modular": 0.9753, "constant-max": 0.9849, "constant-mean": 0.9996}
"""Of the exponential law, the worst over the angles of ``DESIGNS``."""
CURVES = {0.0: (10.21, -1.567), 30.0: (14.76, -23.94), 45.0: (8.639, -58.67)}
"""kappa = p exp(q CASR) of the human-like condition: p in N/mm, q per unit of CASR, which is not printed."""
