"""From surface EMG and pressing force to variable stiffness schedules.

In Python::

    import emg2vsa

    recording = emg2vsa.read("P01_S1.csv", emg=["EDC", "FDS"], force="Fz", sign=-1)
    emg2vsa.fit(recording)                      # v = a + b ln F of every press, one row each
    emg2vsa.load("study.toml").fits             # the results of a whole study, as DataFrames

The stages are modules, in the order of the data: recordings, extraction, fits, hypotheses, profiles, schedules.
"""

from __future__ import annotations

from casr import __version__ as __version__
from casr.lazy_names import lazy_names

_NAMES = {
    "Emg2vsaError": "errors",
    "Recording": "public.recordings",
    "Results": "public.results",
    "Settings": "public.given",
    "channels": "public.recordings",
    "fit": "public.recordings",
    "load": "public.results",
    "plot_fits": "public.plots",
    "plot_press": "public.plots",
    "plot_specimens": "public.plots",
    "read": "public.recordings",
    "run": "public.results",
    "samples": "public.recordings",
    "schedule": "public.schedules",
    "stats": "public.tests",
    "trials": "public.recordings",
}
"""Public name to the module below this package that has it; loaded when it is first asked for."""
__all__ = ["__version__", *_NAMES]

__getattr__, __dir__ = lazy_names(__name__, _NAMES)
