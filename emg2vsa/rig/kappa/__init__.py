"""Stiffness of the specimen while it is pressed: frames and forces of the running rig to kappa and its interval."""
