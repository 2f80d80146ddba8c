"""Two files on one clock by a trigger that both recorded: its rising edges are the same moments."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from emg2vsa.errors import RecordingError
from emg2vsa.readers.opened import StoredChannel

LOW, HIGH = 0.25, 0.75
"Of the way from the trigger's lowest to its highest value: an edge leads from below the one to above the other."
AGREE_S = 0.005
"Edges of one trigger lie equally far apart in both files, but for this."


def clock_offset_s(emg_file: Path, emg: StoredChannel, force_file: Path, force: StoredChannel) -> tuple[float, str]:
    """What is added to the times of the force's file, seconds, and what is to be said of it.

    RecordingError where either channel has no edge, or the two have not the same edges.
    """
    emg_s, force_s = _edges_s(emg_file, emg), _edges_s(force_file, force)
    where = f"{force_file}, channel {force.name!r}"
    if emg_s.size != force_s.size:
        raise RecordingError(
            where, wanted=f"the {emg_s.size} rising edges of channel {emg.name!r} in {emg_file.name}",
            found=f"{force_s.size}", do="Cut both files to the same edges, or name channels that recorded one trigger.",
        )  # fmt: skip
    offsets_s = emg_s - force_s
    apart_s = float(np.ptp(offsets_s))
    if apart_s > AGREE_S:
        raise RecordingError(
            where, wanted=f"edges that lie as far apart as those in {emg_file.name}, within {1e3 * AGREE_S:g} ms",
            found=f"a difference of {1e3 * apart_s:.3g} ms", do="Check the rates of both files, and the trigger.",
        )  # fmt: skip
    offset_s = float(np.median(offsets_s))
    edges = "1 edge" if emg_s.size == 1 else f"{emg_s.size} edges within {1e3 * apart_s:.2g} ms"
    return offset_s, f"clocks: force moved by {1e3 * offset_s:.1f} ms, by {edges} of the trigger in both files"


def _edges_s(path: Path, channel: StoredChannel) -> NDArray[np.float64]:
    """Times of the rising edges, interpolated between samples."""
    samples = channel.samples
    lowest, highest = float(np.nanmin(samples)), float(np.nanmax(samples))
    state = np.where(samples > lowest + HIGH * (highest - lowest), 1, 0)
    state -= samples < lowest + LOW * (highest - lowest)
    decided = np.flatnonzero(state)
    rising = np.flatnonzero((state[decided][1:] > 0) & (state[decided][:-1] < 0)) if highest > lowest else decided[:0]
    if rising.size == 0:
        raise RecordingError(
            f"{path}, channel {channel.name!r}", wanted="a trigger with a rising edge",
            found=f"{lowest:.4g} to {highest:.4g} without one", do="Name the channel that recorded the trigger.",
        )  # fmt: skip
    before, after = decided[rising], decided[rising + 1]
    middle = (lowest + highest) / 2
    at = []
    for first, last in zip(before.tolist(), after.tolist(), strict=True):
        up = first + int(np.argmax(samples[first : last + 1] >= middle))
        step = samples[up] - samples[up - 1]
        at.append(up - (samples[up] - middle) / step)
    return channel.start_s + np.array(at) / channel.fs_hz
