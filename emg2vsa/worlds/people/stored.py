"""The channels as a file stores them: name, gain, unit and sign are those the study tells the reader to undo."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from emg2vsa.errors import SettingError
from emg2vsa.settings import EmgChannelSettings, ForceChannelSettings
from emg2vsa.worlds.people.plan import PlannedRecording
from emg2vsa.worlds.people.recording import SyntheticRecording

FloatArray = NDArray[np.float64]

VOLTS = {"V": 1.0, "mV": 1e-3, "uV": 1e-6}
NEWTONS = {"N": 1.0, "mN": 1e-3, "kN": 1e3, "lbf": 4.4482216152605, "kgf": 9.80665, "gf": 9.80665e-3}


@dataclass(frozen=True)
class StoredChannel:
    """One channel of a file. samples : (n,) in ``unit``, "" where there is none. muscle : None for force."""

    name: str
    samples: FloatArray
    unit: str
    muscle: str | None


def stored_channels(planned: PlannedRecording, recording: SyntheticRecording, emg_unit: str) -> list[StoredChannel]:
    """EMG channels, then force. emg_unit : unit of EMG where the study does not name one."""
    channels = planned.channels
    emg = [_stored_emg(muscle, recording.emg_v[muscle], setting, emg_unit) for muscle, setting in channels.emg.items()]
    return [*emg, _stored_force(recording.force_n, channels.force)]


def _stored_emg(muscle: str, emg_v: FloatArray, setting: EmgChannelSettings, default_unit: str) -> StoredChannel:
    unit = setting.unit or default_unit
    scale = VOLTS[unit] / setting.gain
    return StoredChannel(setting.name, emg_v / scale, unit, muscle)


def _stored_force(force_n: FloatArray, setting: ForceChannelSettings) -> StoredChannel:
    if setting.newtons_per_unit is not None:
        unit, newtons = setting.unit or "", setting.newtons_per_unit
    else:
        unit = setting.unit or "N"
        if unit not in NEWTONS:
            raise SettingError(
                f"force channel {setting.name!r}, unit",
                wanted="N, mN, kN, lbf, kgf or gf, or newtons_per_unit",
                found=repr(unit),
                do="Declare newtons_per_unit.",
            )
        newtons = NEWTONS[unit]
    scale = setting.sign * newtons
    return StoredChannel(setting.name, force_n / scale, unit, None)


def number_rows(columns: Sequence[NDArray[np.float64]], formats: Sequence[str]) -> str:
    """CSV rows of equally long columns, each with its printf format, lines ended by a line feed."""
    table = np.column_stack(columns)
    line = ",".join(formats) + "\n"
    text: str = line * table.shape[0] % tuple(table.ravel().tolist())
    return text
