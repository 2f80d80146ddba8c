"""What ``import emg2vsa`` offers in Python: files, arrays and tables in, pandas DataFrames out.

Every frame has its units in the names of its columns, and in ``attrs`` where it comes from.
"""
