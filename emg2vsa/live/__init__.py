"""Live pages: a process of its own that follows the folder of a run as it grows; the two pages of a session."""
