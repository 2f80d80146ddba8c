"""The folder of a run: plan, log, presses and how it ended."""
