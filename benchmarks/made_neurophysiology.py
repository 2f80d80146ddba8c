"""Small files of neurophysiology programs, made by code after the published layouts: none is a real file.

No public file of these formats has a licence that lets it lie here. Each function returns or writes what neo reads, and
the truth in the units of the file.
"""

from __future__ import annotations

import json
import struct
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Counts = NDArray[np.int16]


def counts(n: int, seed: int) -> Counts:
    """(n,) numbers as a converter gives them."""
    return np.random.default_rng(seed).integers(-2000, 2000, n, dtype=np.int16)


def spike2(channels: dict[str, tuple[Counts, int, float, str]], pause: int = 0) -> bytes:
    """A Spike2 file (.smr) of version 6, whose clock ticks every 10 us.

    channels : name to (samples, ticks a sample, scale, unit); a sample is worth scale / 6553.6. pause : ticks that are
    missing after the first half of each channel.
    """
    per_block, head_bytes, about_bytes = 512 - 20, 512, 140
    first = -(-(head_bytes + about_bytes * len(channels)) // 512)
    abouts, blocks = b"", b""
    for number, (name, (samples, divide, scale, unit)) in enumerate(channels.items()):
        half = samples.size // 2
        parts: list[tuple[int, Counts]] = []
        for begin, stop, later in ((0, half, 0), (half, samples.size, pause)):
            for at in range(begin, stop, per_block // 2):
                part = samples[at : min(at + per_block // 2, stop)]
                parts.append((at * divide + later, part))
        at_block = first + len(blocks) // 512
        for i, (tick, part) in enumerate(parts):
            before, after = at_block + i - 1 if i else -1, at_block + i + 1 if i + 1 < len(parts) else -1
            last = tick + (part.size - 1) * divide
            head = struct.pack("<iiiihh", before * 512, after * 512, tick, last, number + 1, part.size)
            blocks += (head + part.astype("<i2").tobytes()).ljust(512, b"\0")
        places = (0, 0, at_block * 512, (at_block + len(parts) - 1) * 512, len(parts), 0, 0, 0, 512, per_block // 2)
        abouts += struct.pack("<hiiihhhhhh", *places) + bytes(72)
        abouts += struct.pack("<iih10pfBb", 0, divide, number, name.encode(), 0.0, 1, 0)
        abouts += struct.pack("<ff6ph", scale, 0.0, unit.encode(), 0)
        abouts = abouts.ljust(about_bytes * (number + 1), b"\0")
    head = struct.pack(
        "<h10s8shhhihhhhhidBh", 6, b"(C) CED 87", b"", 10, 1, 0, 0, len(channels), 0, 0, 0, 0, 0, 1e-6, 0, 0
    )
    return (head.ljust(head_bytes, b"\0") + abouts).ljust(first * 512, b"\0") + blocks


def axon(samples: Counts, fs_hz: float, sweeps: int = 1) -> bytes:
    """An Axon file of version 1.8, whole numbers over +-10 V at 16 bits; samples (n, channels), all sweeps alike long.

    Channels are EDC in mV, with 0.01 V a mV, and Fz in N, with 0.5 V a N. Sweeps begin two seconds apart.
    """
    n, n_channels = samples.shape
    head = bytearray(6144)

    def put(at: int, form: str, *values: float | bytes) -> None:
        struct.pack_into("<" + form, head, at, *values)

    data_block = len(head) // 512
    synch_block = data_block + -(-samples.nbytes // 512)
    each = n // sweeps
    put(0, "4sfhihi", b"ABF ", 1.8, 5 if sweeps > 1 else 3, samples.size, 0, sweeps)
    put(20, "ii", 20260502, 36000)
    put(40, "i", data_block)
    put(92, "ii", synch_block, sweeps)
    put(120, "hf", n_channels, 1e6 / (fs_hz * n_channels))
    put(130, "f", 0.0)
    put(138, "i", each * n_channels)
    put(244, "f", 10.0)
    put(252, "i", 32768)
    put(378, "16h", *range(16))
    put(410, "16h", *range(n_channels), *[-1] * (16 - n_channels))
    put(442, "10s10s", b"EDC".ljust(10), b"Fz".ljust(10))
    put(602, "8s8s", b"mV".ljust(8), b"N".ljust(8))
    for at in (730, 1050):
        put(at, "16f", *[1.0] * 16)
    put(922, "16f", 0.01, 0.5, *[1.0] * 14)
    starts = b"".join(struct.pack("<ii", int(i * 2 * fs_hz), each * n_channels) for i in range(sweeps))
    return (bytes(head) + samples.astype("<i2").tobytes()).ljust(synch_block * 512, b"\0") + starts


def intan(amplifier: NDArray[np.uint16], board: NDArray[np.uint16], fs_hz: float) -> bytes:
    """An Intan file (.rhd) of version 2: EDC on the amplifier, Fz on the board; (n,) with n a multiple of 128."""

    def text(said: str) -> bytes:
        return struct.pack("<I", 2 * len(said)) + said.encode("utf-16-le")

    def channel(native: str, custom: str, kind: int) -> bytes:
        return text(native) + text(custom) + struct.pack("<10hff", 0, 0, kind, 1, 0, 0, 0, 0, 0, 0, 0.0, 0.0)

    head = struct.pack("<Ihhfhffffffhff", 0xC6912702, 2, 0, fs_hz, 1, 1, 1, 7500, 1, 1, 7500, 0, 1000, 1000)
    head += text("") * 3 + struct.pack("<hh", 0, 0) + text("n/a") + struct.pack("<h", 2)
    head += text("Port A") + text("A") + struct.pack("<hhh", 1, 1, 1) + channel("A-000", "EDC", 0)
    head += text("Board ADC") + text("ADC") + struct.pack("<hhh", 1, 1, 0) + channel("ANALOG-IN-0", "Fz", 3)
    blocks = b""
    for at in range(0, amplifier.size, 128):
        blocks += np.arange(at, at + 128, dtype="<i4").tobytes()
        blocks += b"".join(each[at : at + 128].astype("<u2").tobytes() for each in (amplifier, board))
    return head + blocks


def save_open_ephys(folder: Path, samples: Counts, fs_hz: float) -> Path:
    """A recording of Open Ephys in its binary format: CH1 of 0.195 uV and ADC1 of 0.15 mV a count; samples (n, 2)."""
    stream = folder / "continuous" / "Acquisition_Board-100.Rhythm"
    stream.mkdir(parents=True)
    named = (("CH1", 0.195, "uV"), ("ADC1", 1.5e-4, "V"))
    about = {
        "folder_name": f"{stream.name}/", "sample_rate": fs_hz, "source_processor_name": "Acquisition Board",
        "source_processor_id": 100, "stream_name": "Rhythm", "recorded_processor": "Record Node",
        "recorded_processor_id": 101, "num_channels": 2,
        "channels": [{"channel_name": name, "bit_volts": volts, "units": unit} for name, volts, unit in named],
    }  # fmt: skip
    (stream / "continuous.dat").write_bytes(samples.astype("<i2").tobytes())
    np.save(stream / "sample_numbers.npy", np.arange(len(samples)) + 500)
    np.save(stream / "timestamps.npy", (np.arange(len(samples)) + 500) / fs_hz)
    path = folder / "structure.oebin"
    path.write_text(json.dumps({"GUI version": "0.6.4", "continuous": [about], "events": [], "spikes": []}))
    return path


def plexon(samples: Counts, fs_hz: int, clock_hz: int = 40000, first: int = 4000, pause: int = 0) -> bytes:
    """A Plexon file (.plx) of version 106 with the channel FP01: +-5 V at gain 100, of 16 bits where spikes have 12.

    first : tick of the first sample. pause : ticks that are missing after the first half.
    """
    began, bits = (2026, 5, 2, 10, 0, 0), (1, 1, 12, 16)
    numbers = (clock_hz, 0, 0, 1, 0, 0, *began, 0, clock_hz, 0.0, *bits, 3000, 5000, 1000)
    head = struct.pack("<Ii128s14id4BHHH18s18s10s", 0x58454C50, 106, b"", *numbers, b"", b"", b"")
    head += bytes(4 * (650 + 650 + 512))
    head += struct.pack("<32s6i128sBBH27i", b"FP01", 0, fs_hz, 100, 1, 1, 0, b"", 0, 0, 0, *[0] * 27)
    blocks, half = b"", samples.size // 2
    for begin, stop, later in ((0, half, 0), (half, samples.size, pause)):
        tick = first + begin * clock_hz // fs_hz + later
        blocks += (
            struct.pack("<HHIHHHH", 5, 0, tick, 0, 0, 1, stop - begin) + samples[begin:stop].astype("<i2").tobytes()
        )
    return head + blocks
