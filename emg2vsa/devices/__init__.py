"""Devices of rigs and sessions: a folder each, with its settings, its opening and its driver."""
