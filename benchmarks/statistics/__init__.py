"""What the statistics cost and how many digits they give, beside the libraries people use.

    python -m benchmarks.statistics

Times are processor time, best of interleaved repeats, one thread. Digits are against exact rational or 40-digit
arithmetic, the worst of a sample of the designs. NIST's data are looked for in EMG2VSA_TEST_DATA or ../shared/data.
"""
