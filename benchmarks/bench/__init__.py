"""``emg2vsa tools bench``: time, error, digits and memory of one task done by this project and by other libraries.

An area (``benchmarks/areas/<name>.py``) gives cases, a case gives ways. How they are timed: docs/decisions/0029.
"""
