"""Nobody, in place of a source of EMG or force: a session without a person runs with --virtual alone."""

from __future__ import annotations

from typing import Literal, NoReturn

from emg2vsa.devices.registry import Around, Kind
from emg2vsa.errors import SettingError
from emg2vsa.session_settings import EmgSettings, SessionForceSettings
from emg2vsa.settings_class import settings_class


@settings_class
class SimulatedEmgSettings(EmgSettings):
    """No device: the EMG of an emulated participant."""

    kind: Literal["simulated"] = "simulated"


@settings_class
class SimulatedForceSettings(SessionForceSettings):
    """No device: the force of an emulated participant."""

    kind: Literal["simulated"] = "simulated"


def _nobody(settings: SimulatedEmgSettings | SimulatedForceSettings, around: Around) -> NoReturn:
    table = "emg" if isinstance(settings, SimulatedEmgSettings) else "force"
    do = "Run the session with --virtual, or choose the kind of the device."
    raise SettingError(f"session.{table}.kind", wanted="a device", found='"simulated"', do=do)


EMG = Kind("emg", SimulatedEmgSettings, open=_nobody)
FORCE = Kind("session-force", SimulatedForceSettings, open=_nobody)
