"""The far end of LSL: outlets."""
