"""What a reader hands over: channels at their native rates, in SI units, each with the conversion it went through."""

from __future__ import annotations

import difflib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from emg2vsa.errors import RecordingError

_MOST_LISTED = 20


@dataclass(frozen=True)
class ChannelInfo:
    """What a file says of one channel, before any sample is read."""

    name: str
    unit: str | None
    fs_hz: float
    n_samples: int


@dataclass(frozen=True)
class Channel:
    """One channel, evenly sampled.

    samples : (n,) float64 in ``unit``. unit : "V", "N" or, where the file's unit is neither, the file's own or "".
    fs_hz : samples a second as the file states, or from the median time step. start_s : time of the first sample.
    conversion : how the stored numbers became ``samples``, e.g. "mV x 0.001".
    overloaded : (n,) where the sensor was beyond its range and ``samples`` are wrong; None where that is not known.
    """

    name: str
    samples: NDArray[np.float64]
    unit: str
    fs_hz: float
    start_s: float
    conversion: str
    overloaded: NDArray[np.bool_] | None = None

    @property
    def duration_s(self) -> float:
        """Length of the channel, s."""
        return self.samples.size / self.fs_hz


@dataclass(frozen=True)
class Recording:
    """The channels that were asked for, in that order, and where they came from."""

    source: Path
    format: str
    channels: tuple[Channel, ...]
    notes: tuple[str, ...] = ()

    def channel(self, name: str) -> Channel:
        """The channel of this name. RecordingError : there is none."""
        for channel in self.channels:
            if channel.name == name:
                return channel
        raise no_such_channel(self.source, name, [c.name for c in self.channels])


def no_such_channel(source: Path, name: str, known: Sequence[str]) -> RecordingError:
    """The error for a channel that a file does not hold, with its nearest names."""
    near = [k for k in known if _squeezed(name) in _squeezed(k)] or difflib.get_close_matches(
        name, known, n=1, cutoff=0.5
    )
    hint = f"Did you mean {near[0]!r}?" if near else "Choose one of these names."
    listed = ", ".join(map(repr, known[:_MOST_LISTED]))
    if len(known) > _MOST_LISTED:
        listed += f" and {len(known) - _MOST_LISTED} more"
    return RecordingError(
        f"{source}, channel {name!r}", wanted="a channel of that name", found=listed or "none", do=hint
    )


def _squeezed(name: str) -> str:
    """For "EMG1" to be found in "Avanti sensor 1: EMG 1"."""
    return name.replace(" ", "").replace("_", "").lower()
