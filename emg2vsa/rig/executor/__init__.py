"""The control loop: one turn, its guards, and the way out."""
