"""The tactile camera."""
