"""The rig's fault matrix and the timing of its loop."""
