from emg2vsa.lab.adaptive_runs import AdaptiveRuns as AdaptiveRuns
from emg2vsa.lab.adaptive_runs import adaptive as adaptive
from emg2vsa.lab.adaptive_runs import next_presses as next_presses
from emg2vsa.lab.by_hand import home as home
from emg2vsa.lab.by_hand import jog as jog
from emg2vsa.lab.by_hand import off as off
from emg2vsa.lab.by_hand import parameters as parameters
from emg2vsa.lab.by_hand import proven_watchdog as proven_watchdog
from emg2vsa.lab.by_hand import tare as tare
from emg2vsa.lab.by_hand import zero as zero
from emg2vsa.lab.commissioning import camera_delay as camera_delay
from emg2vsa.lab.commissioning import check_settings as check_settings
from emg2vsa.lab.commissioning import mend_settings as mend_settings
from emg2vsa.lab.device_states import info as info
from emg2vsa.lab.device_states import scan as scan
from emg2vsa.lab.emulation import emulation as emulation
from emg2vsa.lab.judging import Judging as Judging
from emg2vsa.lab.person import Person as Person
from emg2vsa.lab.pressed import Pressed as Pressed
from emg2vsa.lab.pressing import dry_run as dry_run
from emg2vsa.lab.pressing import load as load
from emg2vsa.lab.pressing import press as press
from emg2vsa.lab.sequence import RunsDone as RunsDone
from emg2vsa.lab.sequence import plates as plates
from emg2vsa.lab.sequence import sequence as sequence
from emg2vsa.live.watch_routes import watch as watch

__all__ = [
    "AdaptiveRuns",
    "Judging",
    "Person",
    "Pressed",
    "RunsDone",
    "adaptive",
    "camera_delay",
    "check_settings",
    "dry_run",
    "emulation",
    "home",
    "info",
    "jog",
    "load",
    "mend_settings",
    "next_presses",
    "off",
    "parameters",
    "plates",
    "press",
    "proven_watchdog",
    "scan",
    "sequence",
    "tare",
    "watch",
    "zero",
]
