"""Channels of a file whose header is read when it is opened, and whose samples are decoded when they are asked for."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from emg2vsa.errors import RecordingError
from emg2vsa.readers.opened import Contents, StoredChannel
from emg2vsa.recordings import ChannelInfo


@dataclass(frozen=True)
class Track:
    """What a header says of one channel; ``fs_hz`` is NaN where it states no rate."""

    name: str
    unit: str | None
    fs_hz: float
    n_samples: int
    start_s: float = 0.0
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class OnDemand:
    """An opened file. decode : the samples (n,) of the channels of these indices, in that order, in their units."""

    path: Path
    contents: Contents
    tracks: tuple[Track, ...]
    decode: Callable[[Sequence[int]], Sequence[NDArray[Any]]]

    def describe(self) -> tuple[ChannelInfo, ...]:
        return tuple(
            ChannelInfo(name, track.unit, track.fs_hz, track.n_samples)
            for name, track in zip(self.contents.names, self.tracks, strict=True)
        )

    def load(self, indices: Sequence[int]) -> list[StoredChannel]:
        return [
            StoredChannel(
                self.contents.names[i], np.array(samples, np.float64), self.tracks[i].unit,
                self.tracks[i].fs_hz, self.tracks[i].start_s, self.tracks[i].notes,
            )
            for i, samples in zip(indices, self.decode(indices), strict=True)
        ]  # fmt: skip


@dataclass(frozen=True)
class CountedRows:
    """Where the rows of a table belong in time, by a counter that the device wrote into every row.

    at : (rows,) index of each row's sample; None where no row is missing. n_samples : samples with the lost ones.
    """

    at: NDArray[np.intp] | None
    n_samples: int
    notes: tuple[str, ...] = ()

    @property
    def n_rows(self) -> int:
        return self.n_samples if self.at is None else self.at.size

    def placed(self, column: NDArray[Any]) -> NDArray[np.float64]:
        """The samples (n_samples,) of a column (rows,), NaN where they were lost."""
        column = column[: self.n_rows]
        if self.at is None:
            return np.asarray(column, np.float64)
        samples = np.full(self.n_samples, np.nan)
        samples[self.at] = column
        return samples


def counted(counter: NDArray[np.float64], name: str, fs_hz: float, modulus: int | None = None) -> CountedRows:
    """Rows by their counter (rows,), which rises by one from row to row and wraps at ``modulus``.

    name : of the counter, for the notes. modulus : None: 16 where the counter never reaches 16, else 65536.
    A counter that stands still (OpenSignals' HDF5 holds it at 65535), or that would mean more lost rows than there are
    rows, is not followed: the rows then count, and a note says so. fs_hz : Hz, for the note on when rows were lost.
    """
    n = counter.size
    if n < 2 or not np.isfinite(counter).all() or np.abs(counter).max() >= 2**53:
        return CountedRows(None, n, (f"{name} holds blank cells; the rows were counted instead.",) if n > 1 else ())
    modulus = modulus or (16 if counter.max() < 16 else 65536)
    step = np.diff(counter).astype(np.int64)
    step = np.where(step < 0, step % modulus, step)
    odd = np.flatnonzero(step != 1)
    if not odd.size:
        return CountedRows(None, n)
    first, lost = int(odd[0]), int((step[odd] - 1).sum())
    if (step == 0).any() or lost > n:
        said = f"{name} goes from {counter[first]:.0f} to {counter[first + 1]:.0f} after row {first + 1}"
        return CountedRows(None, n, (f"{said} ({odd.size} such steps); the rows were counted instead.",))
    note = f"{name}: {lost} samples were lost, the first after {first / fs_hz:.6g} s; they are missing."
    return CountedRows(np.concatenate([[0], np.cumsum(step)]).astype(np.intp), n + lost, (note,))


def refuse_nothing(path: Path, tracks: Sequence[Track]) -> None:
    """RecordingError where a file has no channels, or no channel has samples."""
    if not any(track.n_samples for track in tracks):
        found = f"{len(tracks)} channels without any" if tracks else "no channels"
        raise RecordingError(path, wanted="channels with samples", found=found, do="Export or copy the file again.")
