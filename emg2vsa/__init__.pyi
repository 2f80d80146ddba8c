from casr import __version__ as __version__
from emg2vsa.errors import Emg2vsaError as Emg2vsaError
from emg2vsa.public.given import Settings as Settings
from emg2vsa.public.plots import plot_fits as plot_fits
from emg2vsa.public.plots import plot_press as plot_press
from emg2vsa.public.plots import plot_specimens as plot_specimens
from emg2vsa.public.recordings import Recording as Recording
from emg2vsa.public.recordings import channels as channels
from emg2vsa.public.recordings import fit as fit
from emg2vsa.public.recordings import read as read
from emg2vsa.public.recordings import samples as samples
from emg2vsa.public.recordings import trials as trials
from emg2vsa.public.results import Results as Results
from emg2vsa.public.results import load as load
from emg2vsa.public.results import run as run
from emg2vsa.public.schedules import schedule as schedule
from emg2vsa.public.tests import stats as stats

__all__ = [
    "Emg2vsaError",
    "Recording",
    "Results",
    "Settings",
    "__version__",
    "channels",
    "fit",
    "load",
    "plot_fits",
    "plot_press",
    "plot_specimens",
    "read",
    "run",
    "samples",
    "schedule",
    "stats",
    "trials",
]
