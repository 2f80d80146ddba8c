"""A recording as BDF+ (24-bit European data format), with its cues as annotations."""

from __future__ import annotations

import math

import numpy as np
from edfio import Bdf, BdfSignal, EdfAnnotation, Patient, Recording

from emg2vsa.errors import SettingError
from emg2vsa.synthetic.plan import PlannedRecording
from emg2vsa.synthetic.recording import SyntheticRecording
from emg2vsa.synthetic.stored import StoredChannel

LABEL_CHARACTERS = 16


def bdf_bytes(planned: PlannedRecording, recording: SyntheticRecording, channels: list[StoredChannel]) -> bytes:
    """The whole file. Each channel has its own symmetric range, so a stored value is exact to 3e-8 of that range."""
    if not float(recording.fs_hz).is_integer():
        raise SettingError(
            "simulation.fs_hz",
            wanted="whole samples a second, for BDF stores whole seconds",
            found=f"{recording.fs_hz:g} Hz",
            do="Round it, or write another format.",
        )
    file = Bdf(
        [_signal(channel, recording.fs_hz) for channel in channels],
        patient=Patient(code=planned.participant),
        recording=Recording(startdate=planned.acquired.date(), equipment_code="emg2vsa-synthetic"),
        starttime=planned.acquired.time(),
        annotations=[EdfAnnotation(onset, None, text) for onset, text in cues(recording)],
    )
    return file.to_bytes()


def cues(recording: SyntheticRecording) -> list[tuple[float, str]]:
    """(seconds to the millisecond, "start" or "stop"), in time order: what the participant is told."""
    presses = recording.truth.presses
    start = [(round(float(onset), 3), "start") for onset in presses.cue_start_s]
    stop = [(round(float(onset), 3), "stop") for onset in presses.cue_stop_s]
    return sorted(start + stop)


def _signal(channel: StoredChannel, fs_hz: float) -> BdfSignal:
    if len(channel.name) > LABEL_CHARACTERS or not channel.name.isascii():
        raise SettingError(
            f"channel {channel.name!r}",
            wanted=f"a name of at most {LABEL_CHARACTERS} ASCII characters, for BDF holds no more",
            found=f"{len(channel.name)} characters",
            do="Shorten it, or write another format.",
        )
    limit = _two_digits_above(float(np.max(np.abs(channel.samples))))
    return BdfSignal(
        channel.samples,
        fs_hz,
        label=channel.name,
        transducer_type="force sensor" if channel.muscle is None else "bipolar surface electrode",
        physical_dimension=channel.unit,
        physical_range=(-limit, limit),
    )


def _two_digits_above(value: float) -> float:
    """``value`` rounded up to two significant digits, which fit the eight characters a range may take."""
    unit = 10.0 ** (math.floor(math.log10(value)) - 1)
    limit = math.ceil(value / unit) * unit
    return float(f"{limit:.2g}")
