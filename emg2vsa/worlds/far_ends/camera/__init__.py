"""The far end of the camera."""
