"""A rig is set up by hand: slow moves that a touch ends, checks of its settings, proof of its watchdog."""
