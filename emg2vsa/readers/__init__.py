"""Recording files of every known format: one module a format, one front door, and the roles a study gives channels."""
