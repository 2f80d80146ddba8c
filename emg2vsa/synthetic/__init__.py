"""Whole studies, and single recordings, whose truth is known."""

from emg2vsa.synthetic.simulate import SimulatedStudy, simulate_study

__all__ = ["SimulatedStudy", "simulate_study"]
