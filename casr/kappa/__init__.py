"""Kappa of specimens as a parameter of the forward model: one dome for all presses of a sensor, with intervals."""
