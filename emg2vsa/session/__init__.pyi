from emg2vsa.lab.session_devices import Emulation as Emulation
from emg2vsa.lab.session_devices import Virtual as Virtual
from emg2vsa.lab.session_devices import emulate as emulate
from emg2vsa.lab.session_finish import FinishedSession as FinishedSession
from emg2vsa.lab.session_finish import finish as finish
from emg2vsa.lab.session_replay import ReplayedPress as ReplayedPress
from emg2vsa.lab.session_replay import ReplayedSession as ReplayedSession
from emg2vsa.lab.session_replay import replay as replay
from emg2vsa.lab.session_run import Addresses as Addresses
from emg2vsa.lab.session_run import Pages as Pages
from emg2vsa.lab.session_run import SessionEnd as SessionEnd
from emg2vsa.lab.session_run import resume as resume
from emg2vsa.lab.session_run import run as run

__all__ = [
    "Addresses",
    "Emulation",
    "FinishedSession",
    "Pages",
    "ReplayedPress",
    "ReplayedSession",
    "SessionEnd",
    "Virtual",
    "emulate",
    "finish",
    "replay",
    "resume",
    "run",
]
