"""The samples of a stream on disk: a file that only grows, readable whatever ended it.

A file is a head and blocks. Head: ``E2VSAMP1``, length of the text (uint32), text (JSON: the stream as its source
stated it), CRC-32 of the text (uint32). Block: ``BLK1``, number of samples n (uint32), number of stamps (uint32, n or
0), number of the first sample since the stream's start (uint64), time of arrival of the last one in seconds on the
session's clock (float64), CRC-32 of these four and of all that follows (uint32), then the samples, n x channels float32
in the stream's unit, and the device's own times of the samples, float64 in seconds on the session's clock. All numbers
are little endian. Float32 keeps 24 bits: an error below 6e-8 of each value, less than the converters' own. A block that
does not match its checksum is passed over, and reading goes on at the next one that does.
"""

from __future__ import annotations

import json
import mmap
import struct
import zlib
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from emg2vsa.devices.streams import Block, StreamInfo
from emg2vsa.durable.sealed_file import SealedFile
from emg2vsa.durable.writer import Writer
from emg2vsa.errors import DataError

_MAGIC, _BLOCK = b"E2VSAMP1", b"BLK1"
_HEAD = struct.Struct("<IIQdI")
"""Head of a block, after its mark."""
_COUNTED = struct.Struct("<IIQd")
_LENGTH = struct.Struct("<I")
_LARGEST_HEAD = 1_000_000


def head_bytes(info: StreamInfo) -> bytes:
    """The head of a file of samples."""
    text = json.dumps(asdict(info)).encode()
    return _MAGIC + _LENGTH.pack(len(text)) + text + _LENGTH.pack(zlib.crc32(text))


def block_bytes(block: Block) -> bytes:
    """A block as it stands in the file."""
    samples = np.ascontiguousarray(block.samples, dtype="<f4").tobytes()
    stamps = b"" if block.stamps_s is None else np.ascontiguousarray(block.stamps_s, dtype="<f8").tobytes()
    content = samples + stamps
    counted = _COUNTED.pack(len(block.samples), len(stamps) // 8, block.first, block.arrived_s)
    return _BLOCK + counted + _LENGTH.pack(zlib.crc32(content, zlib.crc32(counted))) + content


class SampleWriter:
    """A new file for a stream of a sitting."""

    def __init__(self, writer: Writer, path: Path, info: StreamInfo) -> None:
        self.path = path
        self._file = SealedFile(path, writer)
        self._file.append(head_bytes(info))

    def append(self, block: Block) -> bool:
        """Add a block; never waits. False where it was given up, because the disk refuses for too long."""
        return self._file.append(block_bytes(block))


@dataclass(frozen=True)
class StoredBlocks:
    """Where the blocks of a file are, in its order, (k,) each. offset : of the samples, bytes. count : samples."""

    first: NDArray[np.int64]
    count: NDArray[np.int64]
    arrived_s: NDArray[np.float64]
    offset: NDArray[np.int64]


class SampleFile:
    """The samples of a stream, read from a file.

    passed_over : bytes that belong to no whole block, such as a torn last one. DataError where there is no head.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        try:
            with path.open("rb") as file:
                content = file.read(len(_MAGIC) + _LENGTH.size + _LARGEST_HEAD)
        except OSError as error:
            raise DataError(
                path, wanted="a file of samples of a session", found=error.strerror or str(error),
                do="Put the file back from a copy.",
            ) from error  # fmt: skip
        self.info, begin = _head(path, content)
        self._channels = len(self.info.channels)
        found = np.array(list(_blocks(path, begin, self._channels)), dtype=np.float64).reshape(-1, 5)
        first, count, arrived_s, offset, stop = found.T
        self.blocks = StoredBlocks(first.astype(np.int64), count.astype(np.int64), arrived_s, offset.astype(np.int64))
        self.passed_over = path.stat().st_size - begin - int(np.sum(stop - offset + len(_BLOCK) + _HEAD.size))

    @property
    def stop(self) -> int:
        """One past the number of the last sample."""
        return int((self.blocks.first + self.blocks.count).max(initial=0))

    def read(self, start: int, stop: int) -> NDArray[np.float64]:
        """(n, channels) samples with the n numbers from ``start`` to ``stop``; NaN for those that are not there."""
        samples = np.full((stop - start, self._channels), np.nan)
        ends = self.blocks.first + self.blocks.count
        with self.path.open("rb") as file:
            for i in np.flatnonzero((self.blocks.first < stop) & (ends > start)).tolist():
                first, n = int(self.blocks.first[i]), int(self.blocks.count[i])
                file.seek(int(self.blocks.offset[i]))
                own = np.frombuffer(file.read(n * 4 * self._channels), dtype="<f4").reshape(n, self._channels)
                low, high = max(first, start), min(first + n, stop)
                samples[low - start : high - start] = own[low - first : high - first]
        return samples


def _head(path: Path, content: bytes) -> tuple[StreamInfo, int]:
    """Head of the file, and its length."""
    try:
        if not content.startswith(_MAGIC):
            raise ValueError(f"that it begins with {content[: len(_MAGIC)]!r}")
        begin = len(_MAGIC) + _LENGTH.size
        if len(content) < begin or len(content) < begin + _LENGTH.unpack_from(content, len(_MAGIC))[0] + _LENGTH.size:
            raise ValueError("a head that is cut short or damaged")
        (length,) = _LENGTH.unpack_from(content, len(_MAGIC))
        text = content[begin : begin + length]
        (checksum,) = _LENGTH.unpack_from(content, begin + length)
        if zlib.crc32(text) != checksum:
            raise ValueError("a head that does not match its checksum")
        stated = json.loads(text)
        return StreamInfo(**{**stated, "channels": tuple(stated["channels"])}), begin + length + _LENGTH.size
    except (ValueError, TypeError, KeyError) as error:
        raise DataError(
            path, wanted="a file of samples of a session", found=str(error) or "a damaged head",
            do="Put the file back from a copy, or remove it: its samples cannot be read.",
        ) from error  # fmt: skip


def _blocks(path: Path, begin: int, channels: int) -> Iterator[tuple[int, int, float, int, int]]:
    """(first, count, arrived_s, where its samples begin and where it ends, bytes) of every whole block."""
    if path.stat().st_size <= begin:
        return
    with path.open("rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as content:
        at = begin
        while (at := content.find(_BLOCK, at)) >= 0:
            samples = at + len(_BLOCK) + _HEAD.size
            if samples > len(content):
                return
            count, stamps, first, arrived_s, checksum = _HEAD.unpack_from(content, at + len(_BLOCK))
            stop = samples + count * 4 * channels + 8 * stamps
            counted = content[at + len(_BLOCK) : at + len(_BLOCK) + _COUNTED.size]
            if stop <= len(content) and zlib.crc32(content[samples:stop], zlib.crc32(counted)) == checksum:
                yield first, count, arrived_s, samples, stop
                at = stop
            else:
                at += 1
