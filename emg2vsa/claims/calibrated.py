"""How often each claim is right in worlds that are known.

``python -m benchmarks.claims RUNS --table --write`` wrote this. Studies of the design that it draws: 14 people,
three mountings of three presses (benchmarks/results/claims).
"""

from __future__ import annotations

from emg2vsa.claims.claim import Right

WORLDS, STUDIES = 31, 500
"How many, and of each."
ANY = Right(0.034, 0.05056, "cell-6x")
"Chance of any false verdict in a report."
CLAIMS = {
    "specimens_differ": Right(0.006, 0.01543, "crossed-14", "holds", 1),
    "others_not_distinct": Right(0, 0.005974, "alike", "refuted", 1),
    "equal_participants": Right(0.004, 0.01254, "drift-constant", "holds", 0.618),
    "gaussian_clusters": Right(0, 0.005974, "alike", "holds", 0.94),
    "log_fit_r2": Right(0, 0.005974, "alike", "holds", 1),
    "interpolation_rmse": Right(0, 0.005974, "alike", "holds", 1),
    "area_same_on_specimens": Right(0.002, 0.009452, "margins-within", "holds", 0),
    "area_changes_with_angle": Right(0, 0.005974, "alike", "holds", 0.998),
    "casr_rigid": Right(0, 0.005974, "alike", "holds", 0.97),
    "casr_human_like": Right(0.002, 0.009452, "condition-6x", "holds", 0.976),
    "casr_constant": Right(0, 0.005974, "alike", "holds", 0.948),
    "fig10_order": Right(0, 0.005974, "alike", "holds", 0.072),
    "fig12_order": Right(0, 0.005974, "alike", "holds", 0.06),
    "fig13_new_specimen": Right(0, 0.005974, "alike", "holds", 0.136),
    "new_specimen_at_minimum": Right(0.004, 0.01254, "people-differ", "holds", 0),
    "human_like_contrast": Right(0.034, 0.05056, "cell-6x", "holds", 0.688),
    "constant_levels": Right(0.002, 0.009452, "condition-6x", "holds", 0),
    "kappa_fit_rigid": Right(0, 0.005974, "alike", "holds", 0.004),
    "kappa_error_rigid": Right(0, 0.005974, "alike", "holds", 0),
    "kappa_fit_human_like": Right(0, 0.005974, "alike", "holds", 0.054),
    "kappa_error_human_like": Right(0, 0.005974, "alike", "holds", 0),
    "kappa_fit_constant": Right(0, 0.005974, "alike", "holds", 0.002),
    "kappa_error_constant": Right(0, 0.005974, "alike", "holds", 0),
    "reduction_vision": Right(0, 0.005974, "alike", "holds", 0),
    "reduction_human_like": Right(0, 0.005974, "alike", "holds", 0),
    "reduction_both": Right(0, 0.005974, "alike", "holds", 0),
}
