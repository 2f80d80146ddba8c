"""ATI transducers: the calibration file that comes with one, and the units it is written in."""
