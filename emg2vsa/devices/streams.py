"""Blocks of samples on the session's clock: what every source of EMG and force hands over."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from emg2vsa.errors import DeviceError


@dataclass(frozen=True)
class StreamInfo:
    """A stream, as its source states it once it has been started.

    kind : "emg" or "force". channels : names, muscle roles or "force". unit : "V" or "N", of every sample handed over.
    fs_hz : stated rate. range_max : largest value that the source can give, in ``unit``; None where it does not say.
    delay_s : fixed delay from the body to arrival, which the time stamps take off.
    facts : what the device says of itself (model, serial, mode, gain, filter), for the record.
    frame : samples that the device sends, and can lose, at once.
    stamped : times of blocks are the device's own, which may be early as well as late.
    """

    kind: str
    channels: tuple[str, ...]
    unit: str
    fs_hz: float
    range_max: float | None = None
    delay_s: float = 0.0
    facts: dict[str, str] = field(default_factory=dict)
    frame: int = 1
    stamped: bool = False


class Block(NamedTuple):
    """Consecutive samples of a stream.

    samples : (n, channels) in the stream's unit; NaN where the source says that a sample is lost but has a place.
    first : running number of the first sample since the stream's start, lost ones counted where they are known.
    arrived_s : when the last sample arrived, on the session's clock, ``delay_s`` not taken off; or its time in
    ``stamps_s``.
    stamps_s : (n,) the device's own times of the samples on the session's clock, not smoothed; None where it has none.
    """

    samples: NDArray[np.float64]
    first: int
    arrived_s: float
    stamps_s: NDArray[np.float64] | None = None


class StreamCounts(NamedTuple):
    """Since the start: samples that came, and samples known to be lost (with or without a place)."""

    samples: int = 0
    lost: int = 0


class SourceBase:
    """A source with a stream of its own. What the source states of the stream is known once it has been started."""

    _info: StreamInfo | None = None
    _where: str
    _started = "stream"

    @property
    def info(self) -> StreamInfo:
        """Known once started. DeviceError : it was not."""
        if self._info is None:
            raise self._not_started()
        return self._info

    def _not_started(self) -> DeviceError:
        wanted, do = f"a started {self._started}", "Start the source first."
        return DeviceError(self._where, wanted=wanted, found="none", do=do)


class Source(Protocol):
    """A device that measures by itself once started. DeviceError when it is lost, with what to do."""

    @property
    def info(self) -> StreamInfo:
        """Known once started."""

    def start(self) -> None:
        """Begin, and return once first samples have come. DeviceError when none come.

        After a DeviceError of `read`, `start` begins a new stream: samples and counts from 0.
        """

    def read(self) -> list[Block]:
        """Blocks since the last call, oldest first; never waits."""

    def counts(self) -> StreamCounts:
        """Since the start."""

    def close(self) -> None:
        """Stop measuring and give the device back; never raises."""
