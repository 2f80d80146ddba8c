"""What the verdict on every trial of a record rests on."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from emg2vsa.arrays import Floats
from emg2vsa.signals.envelope import Smoother
from emg2vsa.signals.force import ForceRecord
from emg2vsa.signals.pairing import Instants
from emg2vsa.signals.quality import RawQuality, falling_share, raw_qualities
from emg2vsa.signals.verdicts import Evidence
from emg2vsa.trials.emg_record import EmgRecord


def record_qualities(record: EmgRecord, instants: Instants, envelope: Smoother) -> list[list[RawQuality]]:
    """Quality by muscle and trial, of all raw samples under the envelope's kernel."""
    starts = np.maximum(instants.first - envelope.before, 0)
    stops = instants.last + envelope.after + 1
    windows = [slice(i, j) for i, j in zip(starts.tolist(), stops.tolist(), strict=True)]
    return [
        raw_qualities([samples[window] for window in windows], [gone[window] for window in windows], record.fs_hz)
        for samples, gone in zip(record.samples, record.missing, strict=True)
    ]


def gather_evidence(
    force: ForceRecord,
    instants: Instants,
    force_n: Floats,
    force_missing: NDArray[np.bool_],
    quality: list[list[RawQuality]],
    snr_db: Floats,
    record: EmgRecord,
    sign_doubt: str,
) -> list[Evidence]:
    """What is known of each press of a record; arrays as in ``extract_trials``."""
    presses, offsets = force.presses, instants.offsets
    fs_hz = force.fs_hz
    evidence = []
    for i, (start_s, stop_s) in enumerate(zip(presses.start_s, presses.stop_s, strict=True)):
        curve_n = force_n[offsets[i] : offsets[i + 1]]
        begin, end = int(start_s * fs_hz), min(int(np.ceil(stop_s * fs_hz)) + 1, force_missing.size)
        evidence.append(
            Evidence(
                sign_doubt=sign_doubt,
                duration_s=float(stop_s - start_s),
                peak_force_n=float(presses.peak_n[i]),
                reached=bool(presses.reached[i]),
                at_edge=bool(presses.at_edge[i]),
                covered=bool(instants.covered[i]),
                force_missing=int(np.count_nonzero(force_missing[begin:end])),
                falling_share=falling_share(curve_n, force.reversal_n),
                rest_gap_n=float(force.gap_n[i]),
                start_force_n=float(force.force_n[begin]),
                emg_fs_hz=record.fs_hz,
                emg={muscle: row[i] for muscle, row in zip(record.muscles, quality, strict=True)},
                snr_db=dict(zip(record.muscles, snr_db[:, i].tolist(), strict=True)),
            )
        )
    return evidence
