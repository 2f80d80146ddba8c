"""The stage from recorded presses to scores, run by run (paper VI)."""

from emg2vsa.run_scores.product import ALGORITHMS, PICTURED_N, ContactPicture, FirstContact, PressCurve, RunScores

__all__ = ["ALGORITHMS", "PICTURED_N", "ContactPicture", "FirstContact", "PressCurve", "RunScores"]
