"""Fits of curves with errors: logarithmic, exponential, straight lines."""
