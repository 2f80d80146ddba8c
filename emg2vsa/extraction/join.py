"""The presses of several recordings of one participant on one specimen, as if they were one."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import fields, replace
from itertools import pairwise
from typing import Any

import numpy as np
from scipy import special

from emg2vsa.errors import SignalError
from emg2vsa.extraction import Trials
from emg2vsa.signals.bias import BiasBudget
from emg2vsa.signals.delays import ESTIMATED
from emg2vsa.signals.lag import DIFFERS_CHANCE, PRESS_SD_S, UNKNOWN, Lag
from emg2vsa.signals.traits import Traits

RATES_ALIKE = 1e-5


def join_trials(parts: Sequence[Trials], files: Sequence[str]) -> Trials:
    """The presses of all ``parts``, numbered on; ``files``: the name of each, as notes give it.

    Times run on: each recording begins at the whole second after the end of the one before it. Levels of rest are
    medians of the recordings, shares of clipped samples and of mains the largest, the lag their mean. A lag that no
    recording alone is certain of, and lags that differ, are remarks. A fault is one of the whole only where every
    recording has it; else it is a remark, and the presses that it rejects stay rejected.

    Raises SignalError where muscles, unit or rate differ from those of the first; a rate by more than a hundred
    thousandth, which a file may round it by.
    """
    first = parts[0]
    if len(parts) == 1:
        return first
    for part, file in zip(parts, files, strict=True):
        for name, unit in (("muscles", ""), ("activity_unit", ""), ("fs_hz", " Hz")):
            own, wanted = getattr(part, name), getattr(first, name)
            same = math.isclose(own, wanted, rel_tol=RATES_ALIKE) if name == "fs_hz" else own == wanted
            if not same:
                raise SignalError(
                    file, wanted=f"{name} {wanted}{unit}, as in {files[0]}", found=f"{own}{unit}",
                    do="Give recordings of one participant on one specimen the same channels and rates.",
                )  # fmt: skip
    starts_s = _starts_s(parts)
    shifted = {name: [getattr(part, name) + start for part, start in zip(parts, starts_s, strict=True)]
               for name in ("start_s", "stop_s", "overview_time_s")}  # fmt: skip
    joined: dict[str, Any] = {name: np.concatenate(values) for name, values in shifted.items()}
    for field in fields(Trials):
        if field.name in _JOINED:
            joined[field.name] = _JOINED[field.name]([getattr(part, field.name) for part in parts])
    joined["notes"] = (_said(parts, files, starts_s), *joined["notes"])
    joined["overviews"] = tuple(
        replace(overview, start_s=overview.start_s + start)
        for part, start in zip(parts, starts_s, strict=True)
        for overview in part.overviews
    )
    lag = _lag(parts)
    joined["lag_s"], joined["lag_se_s"] = lag.lag_s, lag.se_s
    joined["remarks"] = (*joined["remarks"], *_lag_remarks(lag, parts))
    if not joined["fault"]:
        faults = [f"{_name(file)}: {part.fault}" for part, file in zip(parts, files, strict=True) if part.fault]
        joined["remarks"] = (*joined["remarks"], *faults)
    return Trials(**joined)


def _starts_s(parts: Sequence[Trials]) -> list[float]:
    """What is added to the times of each recording: whole seconds, 0 for the first."""
    starts = [0.0]
    for before, after in pairwise(parts):
        end = before.overview_time_s[-1] + starts[-1]
        starts.append(float(np.ceil(end + 1e-9) - np.floor(after.overview_time_s[0])))
    return starts


def _said(parts: Sequence[Trials], files: Sequence[str], starts_s: Sequence[float]) -> str:
    told, number = [], 0
    for part, file, start in zip(parts, files, starts_s, strict=True):
        n = part.repetition.size
        presses = "no press" if n == 0 else f"press {number + 1}" if n == 1 else f"presses {number + 1} to {number + n}"
        told.append(f"{_name(file)} ({presses}, times + {start:g} s)")
        number += n
    return f"{len(parts)} recordings joined: {', '.join(told)}"


def _lag(parts: Sequence[Trials]) -> Lag:
    """Mean lag, and a standard error that covers what the recordings differ by; each recording is one piece.

    Weighted by the inverse of the variances where all are known, else by the numbers of presses.
    """
    known = [part for part in parts if np.isfinite(part.lag_s)]
    if len(known) < 2:
        return next((Lag(part.lag_s, part.lag_se_s, 1) for part in known), UNKNOWN)
    lag_s, se_s = np.array([part.lag_s for part in known]), np.array([part.lag_se_s for part in known])
    sure = bool(np.all(se_s > 0))
    weights = se_s**-2 if sure else np.array([max(part.repetition.size, 1) for part in known], dtype=np.float64)
    own_s = weights.sum() ** -0.5 if sure else PRESS_SD_S / weights.sum() ** 0.5
    weights /= weights.sum()
    mean_s = float(weights @ lag_s)
    n, apart_s = len(known), lag_s - mean_s
    between_s = float(weights @ apart_s**2 / (n - 1)) ** 0.5
    by_chance = sure and float(np.sum((apart_s / se_s) ** 2)) < special.chdtri(n - 1, DIFFERS_CHANCE)
    differs_s = 0.0 if n < 3 or by_chance else between_s * n**0.5
    return Lag(mean_s, max(float(own_s), between_s), n, between_s=differs_s)


def _lag_remarks(lag: Lag, parts: Sequence[Trials]) -> tuple[str, ...]:
    """What the recordings tell of the lag together, and no press of them tells alone."""
    told = any("lag" in part.bias.causes or any(name == ESTIMATED for name, _ in part.delay.parts) for part in parts)
    own = [f"force follows EMG by {1e3 * lag.lag_s:.0f} ms, which {lag.pieces} recordings together show"]
    return (*(own if lag.certain and lag.pieces > 1 and not told else ()), *((lag.differs,) if lag.differs else ()))


def _name(file: str) -> str:
    """Without its folders."""
    return file.replace("\\", "/").rpartition("/")[2]


def _offsets(values: Sequence[Any]) -> Any:
    lengths = np.concatenate([np.diff(value) for value in values])
    return np.concatenate((np.zeros(1, np.int64), np.cumsum(lengths)))


def _median(values: Sequence[Any]) -> Any:
    """Median (m,) over the recordings that have a level; NaN where none has."""
    levels = [[level for level in of_muscle if np.isfinite(level)] for of_muscle in np.transpose(values).tolist()]
    return np.array([float(np.median(known)) if known else np.nan for known in levels])


_JOINED: dict[str, Callable[[Sequence[Any]], Any]] = {
    **dict.fromkeys(
        ("participant", "specimen", "muscles", "activity_unit", "fs_hz", "delay", "began", "rates_hz", "equipment"),
        lambda values: values[0],
    ),
    **dict.fromkeys(
        (
            "duration_s",
            "peak_force_n",
            "falling_share",
            "snr_db",
            "verdict",
            "force_n",
            "activity",
            "overview_force_n",
            "zero_shift_n",
            "visit",
        ),
        np.concatenate,
    ),
    "repetition": lambda values: np.arange(1, sum(map(len, values)) + 1),
    "offsets": _offsets,
    "envelopes_v": lambda values: np.concatenate(values, axis=1),
    "rest_force_n": lambda values: float(np.median(values)),
    "rest_envelope_v": _median,
    "mains_ratio": lambda values: np.max(values, axis=0),
    "clip_share": lambda values: np.max(values, axis=0),
    "reasons": lambda values: tuple(reason for value in values for reason in value),
    "notes": lambda values: tuple(dict.fromkeys(note for value in values for note in value)),
    "fault": lambda values: values[0] if all(values) else "",
    "remarks": lambda values: tuple(dict.fromkeys(remark for value in values for remark in value)),
    "bias": BiasBudget.joined,
    "traits": Traits.joined,
    "tare": lambda values: next((value for value in values if value != "impossible"), "impossible"),
}
"""Field of ``Trials`` to what becomes of its values; times, overviews and lags are joined above."""
