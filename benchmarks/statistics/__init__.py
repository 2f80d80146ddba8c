"""Statistical tests and curves by other libraries and in exact arithmetic, for the areas ``fits`` and ``tests``."""
