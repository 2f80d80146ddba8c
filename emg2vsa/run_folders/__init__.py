"""Runs on disk: which there are, and their presses; the rig's own, or anybody's with a table beside them."""
