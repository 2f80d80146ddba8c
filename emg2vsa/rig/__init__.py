"""The rig: actuator, force sensor, camera and motor, driven for real and emulated to the byte."""
