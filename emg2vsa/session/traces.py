"""Force and EMG thinned for the operator's eye: 50 columns a second, each with the extremes of the raw samples."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence

import numpy as np
from scipy import signal

from emg2vsa.arrays import Floats
from emg2vsa.session.views import TraceMessage

COLUMN_S, MESSAGE_S, KEPT_S = 0.02, 0.05, 10.0
ENVELOPE_S = 0.1
"Time constant of the envelope as it is seen live; the analysis has its own."


class LiveEnvelope:
    """Causal envelope, sample by sample: what is left of a mean over a second, rectified, smoothed over `ENVELOPE_S`.

    Both are low-passes of the first order, so the envelope is the same in whatever pieces the samples come.
    """

    def __init__(self, fs_hz: float) -> None:
        self._shares = [1 - math.exp(-1 / (seconds * fs_hz)) for seconds in (1.0, ENVELOPE_S)]
        self._states: list[Floats] = []

    def take(self, samples: Floats) -> Floats:
        """(n, muscles) of samples (n, muscles); NaN where a muscle's sample is none, which changes nothing after it."""
        envelope = np.full(samples.shape, np.nan)
        known = np.isfinite(samples).all(axis=1)
        if (own := samples[known]).size:
            self._states = self._states or [(1 - self._shares[0]) * own[:1], np.zeros((1, own.shape[1]))]
            rectified = np.abs(own - self._smooth(0, own))
            envelope[known] = self._smooth(1, rectified)
        return envelope

    def _smooth(self, which: int, values: Floats) -> Floats:
        share = self._shares[which]
        smooth, self._states[which] = signal.lfilter([share], [1, share - 1], values, axis=0, zi=self._states[which])
        return np.asarray(smooth)


class Traces:
    """``emg`` and ``turn`` are called by the session, ``after`` by any thread."""

    def __init__(self, muscles: Sequence[str]) -> None:
        self._muscles = tuple(muscles)
        self._kept: deque[tuple[int, TraceMessage]] = deque(maxlen=round(KEPT_S / MESSAGE_S))
        self._number = 0
        self._next_column_s = self._next_message_s = -math.inf
        m = len(self._muscles)
        self._envelope_v, self._last_v = np.zeros(m), np.zeros(m)
        self._low_v, self._high_v = np.full(m, np.inf), np.full(m, -np.inf)
        self._columns: list[tuple[float, float, Floats, Floats, Floats]] = []

    def emg(self, samples: Floats, envelope_v: Floats) -> None:
        """Samples (n, muscles) in volts, and their envelope; what is no number is left out."""
        known = np.isfinite(samples).all(axis=1)
        if not known.any():
            return
        samples, self._envelope_v = samples[known], envelope_v[known][-1]
        self._last_v = samples[-1]
        np.minimum(self._low_v, samples.min(axis=0), out=self._low_v)
        np.maximum(self._high_v, samples.max(axis=0), out=self._high_v)

    def turn(self, now_s: float, force_n: float) -> None:
        """A column, and a message, when their time has come."""
        if now_s >= self._next_column_s:
            self._next_column_s = now_s + COLUMN_S - 1e-6
            low_v = np.where(np.isfinite(self._low_v), self._low_v, self._last_v)
            high_v = np.where(np.isfinite(self._high_v), self._high_v, self._last_v)
            self._columns.append((now_s, force_n, self._envelope_v, low_v, high_v))
            self._low_v.fill(np.inf)
            self._high_v.fill(-np.inf)
        if now_s >= self._next_message_s and self._columns:
            self._next_message_s = now_s + MESSAGE_S - 1e-6
            self._number += 1
            self._kept.append((self._number, self._message()))
            self._columns = []

    def after(self, number: int) -> tuple[int, TraceMessage]:
        """What came after the message of a number, of the last ten seconds at most, and the newest number."""
        kept = list(self._kept)
        newer = [message for own, message in kept if own > number]
        joined = TraceMessage([], [], self._none(), self._none(), self._none())
        for message in newer:
            joined.time_s.extend(message.time_s)
            joined.force_n.extend(message.force_n)
            for muscle in self._muscles:
                joined.envelopes_v[muscle].extend(message.envelopes_v[muscle])
                joined.low_v[muscle].extend(message.low_v[muscle])
                joined.high_v[muscle].extend(message.high_v[muscle])
        return (kept[-1][0] if kept else 0), joined

    def _none(self) -> dict[str, list[float]]:
        return {muscle: [] for muscle in self._muscles}

    def _message(self) -> TraceMessage:
        times, forces, *volts = zip(*self._columns, strict=True)
        by_muscle = [
            {muscle: [float(f"{column[m]:.4g}") for column in rows] for m, muscle in enumerate(self._muscles)}
            for rows in volts
        ]
        rounded = [round(force, 4) for force in forces]
        return TraceMessage([round(time, 4) for time in times], rounded, *by_muscle)
