"""From surface EMG and pressing force to variable stiffness schedules.

The stages are modules, in the order of the data: recordings, trials, fits, hypotheses, profiles, schedules.
"""

__version__ = "0.2.0"
