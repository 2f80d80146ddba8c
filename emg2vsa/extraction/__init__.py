"""The stage from signals to trials: its product. ``emg2vsa.extraction.extract`` makes it.

The product stands apart from its making, so that what only reads trials does not load the filters.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from emg2vsa.arrays import Floats, Ints
from emg2vsa.signals.bias import BiasBudget
from emg2vsa.signals.delays import DelayBudget
from emg2vsa.signals.overview import EmgOverview
from emg2vsa.signals.traits import Traits

__all__ = ["DelayBudget", "Trials"]


@dataclass(frozen=True)
class Trials:
    """The presses of one recording in time order; (n,) unless said, times on the recording's clock.

    Rejected trials stay. ``offsets`` cuts the ragged arrays: trial i is ``[offsets[i]:offsets[i + 1]]``.
    """

    participant: str
    specimen: str
    muscles: tuple[str, ...]
    repetition: Ints
    "Number of the press, from 1, in time order."
    start_s: Floats
    "Last rise through the lower force before the upper force is first reached."
    stop_s: Floats
    "First reach of the upper force; of a press that never reaches it, its peak."
    duration_s: Floats
    peak_force_n: Floats
    falling_share: Floats
    "Share of the force path between start and stop that falls, noise left out."
    snr_db: Floats
    "Mean envelope over that of the rest, of the muscle with the lowest; NaN without a rest."
    verdict: NDArray[np.str_]
    "ok or rejected; ``emg2vsa.fits`` calls presses doubtful, for it knows their intervals."
    reasons: tuple[str, ...]
    fs_hz: float
    "Rate of the ragged arrays."
    offsets: Ints
    "(n + 1,)"
    force_n: Floats
    "(N,) tared and filtered, at the instants of the envelopes."
    activity: Floats
    "(N,) co-contraction, in ``activity_unit``."
    envelopes_v: Floats
    "(muscles, N) volts."
    activity_unit: str
    "V, or 1 for normalised and ratio indices."
    rest_force_n: float
    "Median of the tare that was subtracted."
    rest_envelope_v: Floats
    "(muscles,) envelope at rest; NaN without a rest."
    mains_ratio: Floats
    "(muscles,) largest share of power at the mains in any trial."
    clip_share: Floats
    "(muscles,) largest share of clipped samples in any trial."
    overview_time_s: Floats
    "(k,) about 10 Hz over the whole record."
    overview_force_n: Floats
    "(k,) tared, filtered force."
    delay: DelayBudget
    bias: BiasBudget
    "What moves a and b of each press away from the muscle's, cause by cause."
    traits: Traits
    "Traits of the recording, to compare it with others of its study."
    notes: tuple[str, ...]
    "What was run and must be said: Nyquist rule, true -3 dB frequencies, delays, conversions, tare, presses."
    lag_s: float = math.nan
    "Force follows EMG so late (``estimate_lag``), filters and stated delays aside; NaN where it is not known."
    lag_se_s: float = math.nan
    "Its standard error."
    tare: str = "rest"
    "rest: on the lulls; none: as the study says; impossible: the record never rests, and every press says so."
    zero_shift_n: Floats = field(default_factory=lambda: np.empty(0))
    "How far the force's zero moves around each press beside its steady drift, newtons; NaN where it is not known."
    fault: str = ""
    "A mistake in the file or the study file that rejects every press, such as a wrong sign or unit; empty if none."
    remarks: tuple[str, ...] = ()
    "What is doubtful about the recording as a whole; its presses are used."
    overviews: tuple[EmgOverview, ...] = ()
    "The raw EMG of each recording, for its picture."
    began: str = ""
    "When the recording began, as its file states it; that of the first of several."
    rates_hz: tuple[float, ...] = ()
    "Samples a second of each muscle's EMG, then of the force, as recorded."
    equipment: tuple[str, ...] = ()
    "What a side file tells of electrodes and amplifier, such as ``ElectrodeType: wet``."
    visit: NDArray[np.str_] = field(default_factory=lambda: np.empty(0, dtype="<U1"))
    "Label of the visit of each press; empty where the participant comes once."

    def __repr__(self) -> str:
        usable = int(np.count_nonzero(self.verdict != "rejected"))
        of = f"{self.participant} {self.specimen}"
        return f"Trials({of}: {self.repetition.size} presses, {usable} usable, {self.fs_hz:g} Hz)"
