"""The stage from CASR scores of known specimens to the stiffness of an unknown one (paper VI)."""
