"""The channels as a file stores them: named, scaled by gain, unit and sign as the study says the reader will undo them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from emg2vsa.errors import SettingError
from emg2vsa.settings import EmgChannelSettings, ForceChannelSettings
from emg2vsa.synthetic.plan import PlannedRecording
from emg2vsa.synthetic.recording import SyntheticRecording

FloatArray = NDArray[np.float64]

VOLTS = {"V": 1.0, "mV": 1e-3, "uV": 1e-6}
NEWTONS = {"N": 1.0, "mN": 1e-3, "kN": 1e3, "lbf": 4.4482216152605, "kgf": 9.80665, "gf": 9.80665e-3}


@dataclass(frozen=True)
class StoredChannel:
    """One channel of a file. samples : (n,) in ``unit``; muscle is None for force; scale : SI units per stored unit."""

    name: str
    samples: FloatArray
    unit: str
    muscle: str | None
    scale: float


def stored_channels(planned: PlannedRecording, recording: SyntheticRecording, emg_unit: str) -> list[StoredChannel]:
    """EMG channels, then force. emg_unit : unit of EMG where the study does not name one."""
    channels = planned.channels
    emg = [
        _stored_emg(muscle, recording.emg_v[muscle], setting, emg_unit) for muscle, setting in channels.emg.items()
    ]
    return [*emg, _stored_force(recording.force_n, channels.force)]


def _stored_emg(muscle: str, emg_v: FloatArray, setting: EmgChannelSettings, default_unit: str) -> StoredChannel:
    unit = setting.unit or default_unit
    scale = VOLTS[unit] / setting.gain
    return StoredChannel(setting.name, emg_v / scale, unit, muscle, scale)


def _stored_force(force_n: FloatArray, setting: ForceChannelSettings) -> StoredChannel:
    unit = setting.unit or "N"
    newtons = setting.newtons_per_unit or NEWTONS.get(unit)
    if newtons is None:
        raise SettingError(
            f"force channel {setting.name!r}, unit",
            wanted="a unit of force or newtons_per_unit",
            found=repr(unit),
            do="Declare newtons_per_unit.",
        )
    scale = setting.sign * newtons
    return StoredChannel(setting.name, force_n / scale, unit, None, scale)
