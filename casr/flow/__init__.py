"""Optical flow between tactile frames and its divergence over the contact region."""
