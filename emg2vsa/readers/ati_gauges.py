"""The force of an ATI transducer whose six gauges were recorded: their voltages times the matrix of its .cal file."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from emg2vsa.ati import AXES, read_calibration
from emg2vsa.errors import RecordingError
from emg2vsa.readers.opened import StoredChannel
from emg2vsa.readers.units import si_factor
from emg2vsa.recordings import Channel
from emg2vsa.settings import ForceChannelSettings

_LAST_CODE = 3e-4
"""Share of the range by which the last code of a 12-bit converter stays below its end."""


def force_of_gauges(
    path: Path, gauges: Sequence[StoredChannel], settings: ForceChannelSettings, cal_file: Path | None
) -> tuple[Channel, tuple[str, ...]]:
    """The axis ``settings.name`` in N, its sign applied, and what must be said of it.

    gauges : six channels as stored, in the order of the transducer.

    Raises RecordingError: gauges of unequal rate or length, or in no voltage. DeviceError: an unusable .cal file.
    """
    if cal_file is None:
        raise RecordingError(
            f"{path}, force {settings.name!r}", wanted="the transducer's .cal file", found="none",
            do="Name it: cal_file under the force channel of the study.",
        )  # fmt: skip
    calibration = read_calibration(cal_file)
    first = gauges[0]
    for gauge in gauges:
        if (gauge.fs_hz, gauge.start_s, gauge.samples.size) != (first.fs_hz, first.start_s, first.samples.size):
            raise RecordingError(
                f"{path}, channel {gauge.name!r}", wanted=f"{first.samples.size} samples at {first.fs_hz:g} Hz, as "
                f"{first.name!r}", found=f"{gauge.samples.size} at {gauge.fs_hz:g} Hz",
                do="Name the six gauges of one transducer, recorded together.",
            )  # fmt: skip
    volts = np.array([gauge.samples * _volts_per_unit(path, gauge, settings) for gauge in gauges])
    low, high = calibration.range_v
    margin_v = _LAST_CODE * (high - low)
    beyond = (volts <= low + margin_v) | (volts >= high - margin_v)
    notes = [
        f"gauge {gauge.name}: {count} samples at the end of its range ({low:g} to {high:g} V); force is wrong there"
        for gauge, count in zip(gauges, np.count_nonzero(beyond, axis=1).tolist(), strict=True)
        if count
    ]
    force_n = settings.sign * (calibration.wrench_per_volt[AXES.index(settings.name)] @ volts)
    conversion = f"six gauges x {settings.name} of {Path(cal_file).name} (serial {calibration.serial}) = N"
    conversion += "; sign reversed" if settings.sign < 0 else ""
    overloaded = np.any(beyond, axis=0)
    return Channel(settings.name, force_n, "N", first.fs_hz, first.start_s, conversion, overloaded), tuple(notes)


def _volts_per_unit(path: Path, gauge: StoredChannel, settings: ForceChannelSettings) -> float:
    if settings.volts_per_unit is not None:
        return settings.volts_per_unit
    unit = settings.unit or gauge.unit
    known = si_factor(unit)
    if known is None or known[0] != "V":
        raise RecordingError(
            f"{path}, channel {gauge.name!r}", wanted="a gauge in V or mV",
            found=f"unit {unit!r}" if unit else "no unit",
            do='State unit = "V" under the force channel of the study, or volts_per_unit where gauges are in counts.',
        )  # fmt: skip
    return known[1]
