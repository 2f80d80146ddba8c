"""The level of a muscle's maximum voluntary contraction, from recordings of it; and its level at rest."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from emg2vsa.extraction.emg_record import emg_record, filter_chain
from emg2vsa.recordings import Channel
from emg2vsa.settings import FilterSettings

HELD_S = 0.5
"A contraction counts for the envelope's largest mean over this time: one peak is none."


def contraction_levels_v(recordings: Sequence[Mapping[str, Channel]], filters: FilterSettings) -> dict[str, float]:
    """Muscle to its largest level, volts, over recordings of EMG in volts, filtered as presses are.

    Raises SignalError, SettingError as ``extract_trials``, for a recording shorter than 0.5 s among others.
    """
    levels: dict[str, float] = {}
    for emg in recordings:
        record = emg_record(emg)
        chain = filter_chain(filters, record, record.fs_hz)
        envelopes_v = chain.whole(record)
        size = min(envelopes_v.shape[1], max(1, round(HELD_S * record.fs_hz / chain.step)))
        sums = np.cumsum(np.pad(envelopes_v, ((0, 0), (1, 0))), axis=1)
        held_v = (sums[:, size:] - sums[:, :-size]) / size
        for muscle, row in zip(record.muscles, held_v, strict=True):
            levels[muscle] = max(levels.get(muscle, 0.0), float(row.max()))
    return levels


def mean_levels_v(recording: Mapping[str, Channel], filters: FilterSettings) -> dict[str, float]:
    """Muscle to its mean envelope, volts, over a whole recording of EMG in volts, filtered as presses are.

    Raises SignalError, SettingError as ``contraction_levels_v``.
    """
    record = emg_record(recording)
    levels_v = filter_chain(filters, record, record.fs_hz).whole(record).mean(axis=1)
    return dict(zip(record.muscles, levels_v.tolist(), strict=True))
