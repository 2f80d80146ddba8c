"""The stays of a session, cut out of its samples: EMG and force of each on one clock, and nothing resampled.

EMG and force come from two devices, each with a crystal of its own; the clock of a sample is fitted to the times at
which all samples of its sitting arrived (``SampleClock``). The EMG's clock is the clock of a stay: EMG keeps its stated
rate, the force has the rate that it has by that clock, and both begin at one moment, to half a sample of the faster.
A device whose rate is off by more than a crystal can be has its measured rate.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from emg2vsa.errors import DataError
from emg2vsa.session.journal import Line, StreamOpened
from emg2vsa.session.presses import Presses
from emg2vsa.session.raw_files import SampleFile
from emg2vsa.session.sample_clock import SampleClock

Floats = NDArray[np.float64]
LEAD_S, TAIL_S = 2.0, 0.5
"A stay begins when the specimen is placed, or so long before its first START; it ends so long after the last press."
CRYSTAL = 1e-3
"No crystal is off by more: a rate that is, was stated wrongly."
_DRIFT_SAMPLES = 0.3
"Most that force and EMG may move against each other within a stay, in samples, so that data records are whole."
_BEYOND_S = 1.5


class StayWindow(NamedTuple):
    """When a stay was, on the clock of its sitting. stay : of the plan. presses : (press, attempt) begun in it."""

    sitting: int
    stay: int
    phase: str
    specimen: str
    start_s: float
    stop_s: float
    presses: tuple[tuple[int, int], ...]


def stay_windows(presses: Presses) -> list[StayWindow]:
    """The stays with at least one complete press, in time order; one that was interrupted comes in several pieces."""
    found: list[StayWindow] = []
    for own in presses.stays():
        ends = [tried.ended.stop_s for tried in own if tried.ended is not None and tried.ended.how == "complete"]
        if ends:
            first, press, stop_s = own[0], own[0].press, max(ends) + TAIL_S
            start_s = first.begun_s - LEAD_S if first.placed_s is None else min(first.placed_s, first.begun_s)
            keys = tuple(tried.key for tried in own if tried.begun_s < stop_s)
            found.append(StayWindow(first.sitting, press.stay, press.phase, press.specimen, start_s, stop_s, keys))
    return found


@dataclass(frozen=True)
class StaySignals:
    """Samples of a stay. emg_v : (n, muscles), force_n : (m,), NaN where samples were lost. lost : samples lost.

    Sample i of the EMG was at ``start_s + i / (stretch * emg_fs_hz)`` on the session's clock, sample j of the force at
    ``start_s + offset_s`` and so on. measured_hz : of both by the computer's clock. record_s : of the file.
    """

    muscles: tuple[str, ...]
    emg_v: Floats
    force_n: Floats
    emg_fs_hz: float
    force_fs_hz: float
    record_s: float
    start_s: float
    stretch: float
    offset_s: float
    measured_hz: tuple[float, float]
    clock_se_s: tuple[float, float]
    lost: tuple[int, int]
    emg: StreamOpened
    force: StreamOpened

    def onset_s(self, time_s: float) -> float:
        """A time on the session's clock, as seconds from the first sample of the stay."""
        return (time_s - self.start_s) * self.stretch

    @property
    def duration_s(self) -> float:
        """Length of the EMG, s."""
        return len(self.emg_v) / self.emg_fs_hz


@dataclass
class StoredStream:
    """The samples of a stream and their clock. place : number of a sample with those that never came counted."""

    opened: StreamOpened
    file: SampleFile
    clock: SampleClock = field(init=False)
    heard: int = 0
    "Blocks that the clock knows."

    def __post_init__(self) -> None:
        self.clock = SampleClock(
            self.opened.fs_hz, delay_s=self.opened.delay_s, quantum=self.opened.frame, stamped=self.opened.stamped
        )

    def hear(self, stop: float = math.inf) -> StoredStream:
        """Let the clock know the blocks before sample ``stop``, as a session did when it had come so far."""
        blocks = self.file.blocks
        rest = zip(
            *(each[self.heard :].tolist() for each in (blocks.first, blocks.count, blocks.arrived_s)), strict=True
        )
        for first, n, arrived_s in rest:
            if first + n > stop:
                break
            self.clock.add(first, n, arrived_s)
            self.heard += 1
        return self

    def span_s(self) -> tuple[float, float]:
        """Times of the first and the last sample, s."""
        blocks = self.file.blocks
        if blocks.first.size == 0:
            return np.inf, -np.inf
        times_s = self.clock.time_s(np.array([blocks.first.min(), self.file.stop - 1], dtype=np.int64))
        return float(times_s[0]), float(times_s[1])

    @property
    def step_s(self) -> float:
        """Time between two samples, by the computer's clock."""
        last = max(self.file.stop - 1, 1)
        times_s = self.clock.time_s(np.arange(max(0, last - 1_000_000), last + 1, dtype=np.int64))
        steps_s = np.diff(times_s)
        usual_s = float(np.median(steps_s))
        return float(steps_s.sum() / np.rint(steps_s / usual_s).sum())

    def between(self, first: int, n_places: int, step_s: float) -> tuple[Floats, int]:
        """``n_places`` samples (n, channels) from number ``first`` on, evenly in time, and how many are lost."""
        stop = min(first + n_places, self.file.stop)
        times_s = self.clock.time_s(np.arange(first, stop, dtype=np.int64))
        places = np.rint((times_s - times_s[0]) / step_s).astype(np.int64)
        inside = places < n_places
        samples = self.file.read(first, first + int(np.count_nonzero(inside)))
        placed = np.full((n_places, samples.shape[1]), np.nan)
        placed[places[inside]] = samples
        return placed, int(np.count_nonzero(np.isnan(placed[: places[inside].max(initial=0)]).any(axis=1)))


def stored_streams(
    folder: Path, lines: Sequence[Line]
) -> tuple[dict[tuple[int, str], list[StoredStream]], list[DataError]]:
    """The streams of each sitting by (sitting, "emg" or "force"), in the order in which they were opened.

    With them what is wrong with files that cannot be read.
    """
    found: dict[tuple[int, str], list[StoredStream]] = {}
    faults: list[DataError] = []
    for line in lines:
        if isinstance(line.event, StreamOpened):
            try:
                stream = StoredStream(line.event, SampleFile(folder / line.event.file)).hear()
            except DataError as error:
                faults.append(error)
                continue
            if stream.file.blocks.first.size:
                found.setdefault((line.sitting, line.event.name), []).append(stream)
    return found, faults


def cut(window: StayWindow, emg: Sequence[StoredStream], force: Sequence[StoredStream]) -> StaySignals:
    """The samples of a stay, in whole data records. DataError where a stream does not cover it."""
    own_emg, own_force = (_covering(window, streams, name) for streams, name in ((emg, "EMG"), (force, "force")))
    steps_s = (own_emg.step_s, own_force.step_s)
    measured = (1 / steps_s[0], 1 / steps_s[1])
    stated = own_emg.opened.fs_hz
    fs_hz = stated if abs(measured[0] / stated - 1) < CRYSTAL else float(f"{measured[0]:.6g}")
    record, *counts = data_record(fs_hz, fs_hz * measured[1] / measured[0], window.stop_s - window.start_s)
    stretch = measured[0] * record / counts[0]
    first_emg, first_force = _common_start(own_emg, own_force, window.start_s)
    start_s = float(own_emg.clock.time_s(first_emg))
    left = (own_emg.file.stop - first_emg) / counts[0], (own_force.file.stop - first_force) / counts[1]
    records = _records((window.stop_s - start_s) / (steps_s[0] * counts[0]), min(left), TAIL_S / record)
    samples_v, lost_emg = own_emg.between(first_emg, records * counts[0], steps_s[0])
    samples_n, lost_force = own_force.between(first_force, records * counts[1], steps_s[1])
    return StaySignals(
        own_emg.opened.channels, samples_v, samples_n[:, 0], counts[0] / record, counts[1] / record, record, start_s,
        stretch, float(own_force.clock.time_s(first_force)) - start_s, measured,
        (own_emg.clock.report().se_s or np.nan, own_force.clock.report().se_s or np.nan), (lost_emg, lost_force),
        own_emg.opened, own_force.opened,
    )  # fmt: skip


def _records(wanted: float, left: float, tail: float) -> int:
    """Whole data records of a stay: ``wanted`` and a bit, or what is ``left`` of them where that cuts its tail only."""
    whole = max(1, math.ceil(wanted))
    shorter = math.floor(left)
    return shorter if 1 <= shorter < whole and shorter >= wanted - tail else whole


def _covering(window: StayWindow, streams: Sequence[StoredStream], name: str) -> StoredStream:
    """The stream that has all presses of a stay."""
    for stream in reversed(streams):
        first_s, last_s = stream.span_s()
        if first_s < window.stop_s - TAIL_S and last_s > window.stop_s - TAIL_S and first_s <= window.start_s + LEAD_S:
            return stream
    spans = [f"{first_s:.1f} to {last_s:.1f} s" for first_s, last_s in (stream.span_s() for stream in streams)]
    raise DataError(
        f"stay {window.stay} ({window.specimen})",
        wanted=f"{name} from {window.start_s:.1f} to {window.stop_s:.1f} s", found=", ".join(spans) or "no samples",
        do="Its samples stay in sourcedata; repeat the presses if the participant is still there.",
    )  # fmt: skip


def data_record(emg_hz: float, force_hz: float, stay_s: float) -> tuple[float, int, int]:
    """Length of a data record, s, and whole samples of EMG and of force in it.

    The shortest, from a second on, whose records move force and EMG against each other by less than ``_DRIFT_SAMPLES``
    in the whole stay, and end less than ``_BEYOND_S`` after it: at worst one record as long as the stay. The length has
    the eight characters of a BDF header, which moves both rates alike, by less than a millionth.
    """
    n_emg = np.arange(round(emg_hz), math.ceil(emg_hz * (stay_s + _BEYOND_S)) + 1)
    n_force = np.maximum(np.rint(n_emg * (force_hz / emg_hz)), 1)
    drift = np.abs(n_force / (n_emg * (force_hz / emg_hz)) - 1) * stay_s * max(emg_hz, force_hz)
    beyond_s = np.ceil(stay_s * emg_hz / n_emg) * n_emg / emg_hz - stay_s
    good = np.flatnonzero((drift < _DRIFT_SAMPLES) & (beyond_s < _BEYOND_S))
    best = good[0] if good.size else np.argmin(drift + np.maximum(beyond_s, 0))
    return float(f"{n_emg[best] / emg_hz:.6f}"[:8]), int(n_emg[best]), int(n_force[best])


def _common_start(emg: StoredStream, force: StoredStream, start_s: float) -> tuple[int, int]:
    """Numbers of the samples of both that stand closest to each other, at or after a time."""
    slower, faster = (force, emg) if emg.opened.fs_hz >= force.opened.fs_hz else (emg, force)
    anchor = slower.clock.first_after(max(start_s, slower.span_s()[0], faster.span_s()[0]), slower.file.stop)
    at_s = float(slower.clock.time_s(anchor))
    near = max(1, faster.clock.first_after(at_s, faster.file.stop))
    before_s, after_s = (float(faster.clock.time_s(near - 1)), float(faster.clock.time_s(near)))
    other = near if after_s - at_s <= at_s - before_s else near - 1
    return (other, anchor) if faster is emg else (anchor, other)
