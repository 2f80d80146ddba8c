"""The stage from recorded presses to scores, run by run (paper VI)."""

from emg2vsa.runs.product import ALGORITHMS, ContactPicture, PressCurve, RunScores

__all__ = ["ALGORITHMS", "ContactPicture", "PressCurve", "RunScores"]
