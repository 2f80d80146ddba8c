"""The force sensor of a rig as the source of a session's force."""
