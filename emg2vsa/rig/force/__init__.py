"""Force sensors: ATI Net F/T over RDT, and gauge voltages with a calibration file."""
