"""From surface EMG and pressing force to variable stiffness schedules.

The stages are modules, in the order of the data: recordings, trials, fits, hypotheses, profiles, schedules.
"""

from casr import __version__ as __version__
