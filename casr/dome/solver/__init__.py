"""Axisymmetric finite elements of a soft dome pressed on a specimen, which tables of domes are made with."""
