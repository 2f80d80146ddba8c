"""Two files on one clock by a trigger that both recorded: its edges are the same moments.

Rising edges count; where the pulses of the two files are of unequal length, the trigger of the force may have the other
polarity, and its falling edges are tried.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from emg2vsa.errors import RecordingError
from emg2vsa.readers.opened import StoredChannel

LOW, HIGH = 0.25, 0.75
"Shares of the way from the trigger's lowest to its highest value: an edge leads from below the one to above the other."
AGREE_S = 0.005
"Edges of one trigger lie equally far apart in both files, but for this."


def clock_offset_s(emg_file: Path, emg: StoredChannel, force_file: Path, force: StoredChannel) -> tuple[float, str]:
    """What is added to the times of the force's file, seconds, and what is to be said of it.

    RecordingError where either channel has no edge, or the two have not the same edges.
    """
    emg_s, emg_width_s = _pulses_s(emg_file, emg)
    agree_s = AGREE_S + 1 / min(emg.fs_hz, force.fs_hz)
    where = f"{force_file}, channel {force.name!r}"
    first_error: RecordingError | None = None
    found: list[tuple[int, float, str]] = []  # pulses of equal length, offset, what is said
    for edge in ("rising", "falling"):  # one device may hold the line down where the other holds it up
        turned = force if edge == "rising" else replace(force, samples=-force.samples)
        try:
            force_s, width_s = _pulses_s(force_file, turned)
            apart_s = _agreement_s(where, emg_file, emg, emg_s, force_s)
            differ_s = np.abs(width_s - emg_width_s)  # NaN where a pulse has no end in one of the files
            if np.any(differ_s > agree_s):
                raise RecordingError(
                    where, wanted=f"pulses as long as those of channel {emg.name!r} in {emg_file.name}",
                    found=f"a difference of {1e3 * float(np.nanmax(differ_s)):.3g} ms",
                    do="Name channels that recorded one trigger, with one polarity.",
                )  # fmt: skip
        except RecordingError as error:
            first_error = first_error or error
            continue
        offset_s = float(np.median(emg_s - force_s))
        edges = "1 edge" if emg_s.size == 1 else f"{emg_s.size} edges within {1e3 * apart_s:.2g} ms"
        said = f"clocks: force moved by {1e3 * offset_s:.1f} ms, by {edges} of the trigger in both files"
        said += "; it falls in the file of the force where it rises in that of the EMG" if edge == "falling" else ""
        found.append((int(np.count_nonzero(np.isfinite(differ_s))), offset_s, said))
    if not found:
        assert first_error is not None
        raise first_error
    _, offset_s, said = max(found, key=lambda one: one[0])  # of equal ones the first, which rises
    return offset_s, said


def _agreement_s(
    where: str, emg_file: Path, emg: StoredChannel, emg_s: NDArray[np.float64], force_s: NDArray[np.float64]
) -> float:
    """Largest difference, s, of the distances of the edges; RecordingError where they are not the same edges."""
    if emg_s.size != force_s.size:
        raise RecordingError(
            where, wanted=f"the {emg_s.size} rising edges of channel {emg.name!r} in {emg_file.name}",
            found=f"{force_s.size}", do="Cut both files to the same edges, or name channels that recorded one trigger.",
        )  # fmt: skip
    apart_s = float(np.ptp(emg_s - force_s))
    if apart_s > AGREE_S:
        raise RecordingError(
            where, wanted=f"edges that lie as far apart as those in {emg_file.name}, within {1e3 * AGREE_S:g} ms",
            found=f"a difference of {1e3 * apart_s:.3g} ms", do="Check the rates of both files, and the trigger.",
        )  # fmt: skip
    return apart_s


def _pulses_s(path: Path, channel: StoredChannel) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Times of the rising edges, interpolated between samples, and how long it then stays up: NaN to the end."""
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
    falling = decided[1:][(state[decided][1:] < 0) & (state[decided][:-1] > 0)]
    ends = np.append(falling, np.nan)[np.searchsorted(falling, after)]
    return channel.start_s + np.array(at) / channel.fs_hz, (ends - np.array(at)) / channel.fs_hz
