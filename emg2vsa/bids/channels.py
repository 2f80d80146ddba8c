"""Channels of a recording, and the table that stands beside them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from emg2vsa.bids.tables import ABSENT

COLUMNS = (
    "name", "type", "units", "description", "sampling_frequency", "signal_electrode", "reference", "group",
    "target_muscle", "placement_scheme", "placement_description", "interelectrode_distance", "low_cutoff",
    "high_cutoff", "notch", "status", "status_description",
)  # fmt: skip
_MUSCLES = {
    "EDC": "extensor digitorum communis", "FDS": "flexor digitorum superficialis", "FCR": "flexor carpi radialis",
    "FCU": "flexor carpi ulnaris", "ECR": "extensor carpi radialis", "ECU": "extensor carpi ulnaris",
    "FDP": "flexor digitorum profundus",
}  # fmt: skip


def muscle_name(role: str) -> str:
    """Name of a muscle by the role that it mostly has in a study file; the role where it is none of these."""
    return _MUSCLES.get(role.upper(), role)


@dataclass(frozen=True)
class Channel:
    """samples : (n,) finite, in ``unit``, "" where it has none. muscle : its role in the study, None for the force.

    said : what the channel is. told : what is to be known of its samples. stated_hz : the rate as the table has it,
    "" : to ten digits. pair : name of the pair of electrodes, "" : as the channel. placed : what is to be said of where
    they are. electrode_mm : distance of the two, None where it is not known. band_hz : of the amplifier, likewise.
    """

    label: str
    samples: NDArray[np.float64]
    unit: str
    fs_hz: float
    muscle: str | None
    said: str
    told: str = ""
    stated_hz: str = ""
    pair: str = ""
    placed: str = ""
    electrode_mm: float | None = None
    band_hz: tuple[float, float] | None = None

    def cells(self) -> tuple[object, ...]:
        """The channel's row of the table, in the order of ``COLUMNS``."""
        head = (self.label, "EMG" if self.muscle else "MISC", self.unit or ABSENT, self.said)
        rate = self.stated_hz or f"{self.fs_hz:.10g}"
        tail = (ABSENT, "good", self.told or ABSENT)
        if self.muscle is None:
            return (*head, rate, *[ABSENT] * 9, *tail)
        pair, name = self.pair or self.label, muscle_name(self.muscle)
        distance = ABSENT if self.electrode_mm is None else f"{self.electrode_mm:g}"
        where = ("other", f"belly of the {name}{self.placed}", distance, *(self.band_hz or (ABSENT, ABSENT)))
        return (*head, rate, f"{pair}1", f"{pair}2", pair, name, *where, *tail)
