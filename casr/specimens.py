"""The specimens of the paper."""

SPECIMENS = {"S1": 7.63, "S2": 5.32, "S3": 3.35, "S4": 3.12, "S5": 1.11}
"Stiffness by plate indentation, N/mm (paper, section IV.B); S2 is the unknown specimen."
