"""Small recordings of every format that the readers of emg2vsa parse themselves, made by code: none is a real file.

They are the corpus of `benchmarks.fuzz_readers`, and tests read them where no public file of a format exists (Delsys
.mat exports, HPF files of several groups, BITalino with lost samples, LVM files of several segments, Net F/T).
"""

from __future__ import annotations

import json
import struct
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import scipy.io
from numpy.typing import NDArray

N = 96
"""Samples of the fastest channel of most files."""


def wave(n: int, seed: int = 0) -> NDArray[np.float64]:
    """(n,) numbers that differ from file position to file position, about 1 in size."""
    return np.round(np.random.default_rng(seed).normal(size=n), 6)


# Delsys binaries


def hpf(
    groups: Mapping[int, tuple[float, float, Sequence[NDArray[np.float64]]]] | None = None, chunk_samples: int = 40
) -> bytes:
    """An HPF file. groups : number to (stored rate, sensor's rate, samples of each channel)."""
    groups = groups or {1: (1000.0, 1000.0, (wave(N, 1), wave(N, 2))), 2: (500.0, 148.148, (wave(N // 2, 3),))}
    head = b"<HeaderInfoV1><RecordingDate>2024/01/02 03:04:05.6</RecordingDate></HeaderInfoV1>\0"
    parts = [_chunk(0x1000, b"datx" + struct.pack("<qq", 0x10001, 0) + head)]
    for number, (fs_hz, sensor_hz, channels) in groups.items():
        xml = "<ChannelInformationData>"
        for i in range(len(channels)):
            kind, unit = ("EMG", "Volts") if sensor_hz == fs_hz else ("ACC", "g")
            xml += (
                f"<ChannelInformation><Name>{kind} {number}.{i + 1}</Name><Unit>{unit}</Unit>"
                f"<ChannelType>RandomDataChannel</ChannelType><DataType>Float</DataType><DataIndex>{i}</DataIndex>"
                f"<PerChannelSampleRate>{sensor_hz}</PerChannelSampleRate>"
                f"<RequestedPerChannelSampleRate>{fs_hz}</RequestedPerChannelSampleRate></ChannelInformation>"
            )
        body = (xml + "</ChannelInformationData>").encode() + b"\0"
        parts.append(_chunk(0x2000, struct.pack("<ii", number, len(channels)) + body))
    for number, (_, _, channels) in groups.items():
        for first in range(0, channels[0].size, chunk_samples):
            values = [channel[first : first + chunk_samples].astype("<f4").tobytes() for channel in channels]
            at = 32 + 8 * len(values)
            places = [(at + sum(map(len, values[:i])), len(value)) for i, value in enumerate(values)]
            flat = [number for place in places for number in place]
            body = struct.pack(f"<iqi{len(flat)}i", number, first, len(values), *flat) + b"".join(values)
            parts.append(_chunk(0x3000, body))
    return b"".join([*parts, _chunk(0x6000, struct.pack("<q", 0))])


def _chunk(kind: int, body: bytes, multiple: int = 512) -> bytes:
    size = -(-(16 + len(body)) // multiple) * multiple
    return (struct.pack("<qq", kind, size) + body).ljust(size, b"\0")


def demg(counts: NDArray[np.int16] | None = None, version: int = 3, ad_gain: float = 1.0, promised: int = 0) -> bytes:
    """A DEMG file of 2000 Hz; counts (n, channels); 10 V over 16 bits, system gain 1000."""
    counts = np.arange(2 * N, dtype=np.int16).reshape(N, 2) if counts is None else counts
    n, n_channels = counts.shape
    channels = b"".join(
        struct.pack("<II1sI4s6d", i, 1, b"V", 4, f"Ch {i + 1}".encode(), 1000.0, ad_gain, 10 / 65536, 0.0, 20.0, 450.0)
        for i in range(n_channels)
    )
    fixed = struct.Struct("<4sHI11s11s255sIIIIIdd7I")
    at = fixed.size + len(channels)
    numbers = (0, 0, n_channels, promised or n, n, 2000.0, 2000.0, at, 0, 0, 0, 0, 0, 0)
    head = fixed.pack(b"DEMG", version, 1, b"3.1.0.5", b"", b"", *numbers)
    return head + channels + counts.astype("<i2").tobytes() + b"\7CMarker" + bytes(35)


def save_delsys_mat(path: Path, cell: bool = False) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """A .mat export of Delsys' file utility: rates 2148.148 and 148.148 Hz, the slow row padded with zeros."""
    fast, slow = wave(4 * N, 5), wave(4 * N * 148148 // 2148148, 6)
    data = np.zeros((2, 4 * N + 30))
    data[0, : fast.size], data[1, : slow.size] = fast, slow
    fs_hz = np.array([[2148.14819336], [148.14814758]])
    names = ["Muscle: EMG 1", "Muscle: ACC.X 2"]
    channels = np.array(names, dtype=object).reshape(-1, 1) if cell else np.array(names)
    variables = {"Channels": channels, "Fs": fs_hz, "Time": np.arange(data.shape[1]) / fs_hz, "Data": data}
    scipy.io.savemat(path, variables)
    return fast, slow


def c3d_sgi(n_frames: int = 20, per_frame: int = 4) -> bytes:
    """A C3D as SGI/MIPS systems wrote it, big-endian: two analogue channels at 400 Hz, which ezc3d refuses.

    Channel "EMG" counts 0, 1, 2, ... mV; channel "Fz" is the negative of it in N.
    """
    groups: dict[str, dict[str, Any]] = {
        "POINT": {"USED": 0, "SCALE": -1.0, "RATE": 100.0, "DATA_START": 3, "FRAMES": n_frames},
        "ANALOG": {
            "USED": 2, "LABELS": ["EMG", "Fz "], "UNITS": ["mV", "N "], "GEN_SCALE": 1.0, "SCALE": [1.0, 1.0],
            "OFFSET": [0, 0], "RATE": 100.0 * per_frame,
        },
    }  # fmt: skip
    parts = [struct.pack(">BBBB", 1, 0x50, 1, 86)]
    for number, (group, parameters) in enumerate(groups.items(), start=1):
        parts.append(struct.pack(">bb", len(group), -number) + group.encode() + struct.pack(">hB", 3, 0))
        for name, value in parameters.items():
            body = _parameter(value) + b"\0"
            parts.append(
                struct.pack(">bb", len(name), number) + name.encode() + struct.pack(">h", 2 + len(body)) + body
            )
    parameters_block = b"".join([*parts, b"\0\0"]).ljust(512, b"\0")
    head = struct.pack(">BBhhhhhfhhf", 2, 0x50, 0, 2 * per_frame, 1, n_frames, 0, -1.0, 3, per_frame, 100.0)
    count = np.arange(n_frames * per_frame)
    return head.ljust(512, b"\0") + parameters_block + np.stack([count, -count], axis=1).astype(">f4").tobytes()


def _parameter(value: int | float | Sequence[int] | Sequence[float] | Sequence[str]) -> bytes:
    if isinstance(value, list) and isinstance(value[0], str):
        return struct.pack(">bBBB", -1, 2, len(value[0]), len(value)) + "".join(value).encode()
    numbers = value if isinstance(value, list) else [value]
    kind, layout = (2, "h") if isinstance(numbers[0], int) else (4, "f")
    dimensions = bytes([1, len(numbers)]) if isinstance(value, list) else b"\0"
    return struct.pack(">b", kind) + dimensions + struct.pack(f">{len(numbers)}{layout}", *numbers)


# Texts


def opensignals(lost: bool = False, bitalino: bool = False, devices: int = 1) -> bytes:
    """An OpenSignals text; ``lost``: row 10 to 12 are missing."""
    head, rows = {}, [[] for _ in range(N)]  # type: ignore[var-annotated]
    for number in range(devices):
        analog = ["A1", "A2"] if bitalino else ["CH1", "CH2"]
        marks = ["nSeq", "I1", "I2", "O1", "O2"] if bitalino else ["nSeq", "DI"]
        head[f"00:07:80:00:00:0{number}"] = {
            "sensor": ["EMG", "EMG"], "column": [*marks, *analog], "label": analog, "channels": [1, 2],
            "sampling rate": 1000, "resolution": [4, 1, 1, 1, 1, 10, 10] if bitalino else [16, 16],
            "device": "bitalino" if bitalino else "biosignalsplux", "date": "2020-1-2", "time": "3:4:5.6",
        }  # fmt: skip
        for i, row in enumerate(rows):
            row += [(i + 3) % 16 if bitalino else i + 100, *[0] * (len(marks) - 1), 500 + i + number, 700 - i]
    kept = rows[:10] + rows[13:] if lost else rows
    text = ["# OpenSignals Text File Format", "# " + json.dumps(head), "# EndOfHeader"]
    return ("\n".join([*text, *("\t".join(map(str, row)) + "\t" for row in kept)]) + "\n").encode()


def lvm(x_columns: str = "No", segments: int = 2, gap_s: float = 0.0, decimal: str = ",") -> bytes:
    """A LabVIEW file of two channels at 1000 Hz, N samples in segments; ``gap_s`` between segments."""
    text = ["LabVIEW Measurement\t", "Writer_Version\t2", "Separator\tTab", f"Decimal_Separator\t{decimal}"]
    text += ["Multi_Headings\tYes", f"X_Columns\t{x_columns}", "***End_of_Header***\t", "\t"]
    per, waves = N // segments, (wave(N, 1), wave(N, 2))
    for k in range(segments):
        moment_s = 10 + k * (per * 1e-3 + gap_s)
        stamp = f"09:51:{moment_s:018.15f}".replace(".", decimal)
        text += ["Channels\t2", f"Samples\t{per}\t{per}", "Date\t2024/02/19\t2024/02/19", f"Time\t{stamp}\t{stamp}"]
        text += [
            "Y_Unit_Label\tVolts\tNewtons",
            "X0\t0\t0",
            f"Delta_X\t{_decimal(1e-3, decimal)}\t{_decimal(1e-3, decimal)}",
        ]
        text += ["***End_of_Header***\t\t"]
        multi = x_columns == "Multi"
        text += ["X_Value\tEMG\tX_Value\tForce\tComment" if multi else "X_Value\tEMG\tForce\tComment"]
        for i in range(per):
            x = _decimal(i * 1e-3, decimal) if x_columns != "No" else ""
            emg, force = (_decimal(each[k * per + i], decimal) for each in waves)
            text.append("\t".join([x, emg, x, force] if multi else [x, emg, force]))
        text.append("")
    return ("\r\n".join(text) + "\r\n").encode()


def _decimal(value: float, decimal: str) -> str:
    return f"{value:.6f}".replace(".", decimal)


def vicon(skipped_row: int | None = None, trajectories: bool = True) -> bytes:
    """A Nexus export: 4 sub frames a frame, frames from 11 on."""
    text = ["Devices", "400", ",,EMG box,,Plate", "Frame,Sub Frame,EMG1,EMG2,Fz", ",,V,V,N"]
    emg, force = wave(N, 1) * 1e-4, wave(N, 2)
    rows = [f"{11 + i // 4},{i % 4},{emg[i]:.6g},{-emg[i]:.6g},{force[i]:.6g}" for i in range(N)]
    text += rows if skipped_row is None else rows[:skipped_row] + rows[skipped_row + 1 :]
    text += ["", "Trajectories", "100", ",,a", "Frame,Sub Frame,X", ",,mm", "11,0,3.5"] if trajectories else []
    return ("\r\n".join(text) + "\r\n").encode()


def labchart(blocks: int = 1, interval: str = "0,0005 s") -> bytes:
    """A text of LabChart with decimal commas, two channels, and a comment behind one row."""
    text = []
    for _ in range(blocks):
        text += [
            f"Interval=\t{interval}",
            "ExcelDateTime=\t4,5E4\t12.03.2024 10:11:12,345",
            "TimeFormat=\tStartOfBlock",
        ]
        text += ["DateFormat=\t", "ChannelTitle=\tEMG\tKraft", "Range=\t2,000 mV\t50,00 N"]
        rows = zip(np.arange(N) / 2000, wave(N, 1), wave(N, 2), strict=True)
        text += ["\t".join(_decimal(value, ",") for value in row) for row in rows]
        text[-3] += "\t#* pressed"
    return ("\n".join(text) + "\n").encode("latin-1")


def evart(bits: int = 16) -> bytes:
    """An .anc file of 1000 Hz, two channels of ranges 5000 and 10000 mV."""
    text = ["File_Type:\tAnalog R/C ASCII\tGeneration#:\t2", "Board_Type:\tX\tPolarity:\tBipolar"]
    text += [
        "Trial_Name:\ta\tTrial#:\t1\tDuration(Sec.):\t1\t#Channels:\t2",
        f"BitDepth:\t{bits}\tPreciseRate:\t1000.000000",
    ]
    text += ["", "", "", "", "Name\tEMG\tFz\t", "Rate\t1000\t1000\t", "Range\t5000\t10000\t"]
    text += [f"{i / 1000:.6f}\t{3 * i - 40}\t{i}\t" for i in range(N)]
    return ("\r\n".join(text) + "\r\n").encode()


def net_ft(counts: bool = True, lost: bool = False) -> bytes:
    """A file of ATI's Net F/T demo, 7000 Hz, 1000 counts a newton."""
    text = ["Start Time: 1/2/24 3:04 PM", "RDT Sample Rate: 7000", '"PLEASE NOTE: The sample rate is read ..."']
    text += ["Force Units: N", "Counts per Unit Force: 1000.0", "Torque Units: N-mm", "Counts per Unit Torque: 100.0"]
    text += ["Status (hex), RDT Sequence, F/T Sequence, Fx, Fy, Fz, Tx, Ty, Tz, Time"]
    for i in range(N):
        values = [10, -20, 1000 + i, 1, 2, 3]
        cells = values if counts else [v / (1000.0 if k < 3 else 100.0) for k, v in enumerate(values)]
        if not (lost and 10 <= i < 13):
            text.append(",".join(f'"{c}"' for c in ["0x0", i + 1, 5 * i, *cells, "Jan 2, 2024 3:04:05 PM"]))
    return ("\n".join(text) + "\n").encode()


def emgworks(verbose: bool = False) -> bytes:
    """A CSV of EMGworks, bare or verbose."""
    text = []
    if verbose:
        said = "Number of points: {} start: 0.000000e+000 Unit: {} Domain Unit: s"
        for name, fs, n, unit in (
            ("S1: EMG 1", "2.000000e+003", N, "V"),
            ("S1: ACC.X 1", "1.000000e+003", N // 2, "g"),
        ):
            text.append(f"Label: {name} Sampling frequency: {fs} " + said.format(n, unit))
        text += ["Start Trigger Method: None", "Stop Trigger Method: None", ""]
    text.append('X[s],"S1: EMG 1",X[s],"S1: ACC.X 1"')
    for i in range(N):
        slow = f"{i / 1000:.7g},{i * 0.5}" if i < N // 2 else ","
        text.append(f"{i / 2000:.7g},{wave(N)[i] * 1e-4:.7g},{slow}")
    return ("\n".join(text) + "\n").encode()


def discover() -> bytes:
    """A CSV of Trigno Discover 1.5."""
    text = [
        "Application:, Trigno Discover (1.5.0)",
        "Date/Time:, 4/12/2022 5:23:09 PM",
        "Collection Length (seconds):, 0.05",
    ]
    text += ["EMG 01 (1), , ", "sensor mode: 55, , ", "EMG 1 (mV), ACC X (G)", "1259.2593 Hz, 148.1481 Hz"]
    text += [f"{wave(N)[i]}, {i}" if i < 12 else f"{wave(N)[i]}, " for i in range(N)]
    return ("\r\n".join(text) + "\r\n").encode()


def plain_csv() -> bytes:
    rows = [f"{i / 1000};{wave(N, 1)[i]};{wave(N, 2)[i]}".replace(".", ",") for i in range(N)]
    return ("\n".join(["time (s);EDC (mV);Fz [N]", *rows]) + "\n").encode()


def instrument_csv() -> bytes:
    """A table of time stamps below lines of words, with a row of units."""
    rows = "".join(f"2026-05-02 10:00:{i / 100:06.3f},{v},{i}\n" for i, v in enumerate(wave(N)))
    return f"Bluehill\nSampling rate: 100 Hz\n\nTimestamp,EDC,Fz\n,mV,N\n{rows}".encode()


def text_matrix() -> bytes:
    rows = [f"{i / 1000:.6e} {wave(N, 1)[i]:.6e} {wave(N, 2)[i]:.6e}" for i in range(N)]
    return ("\n".join(rows) + "\n").encode()


# What foreign decoders read


def save_tdms(path: Path, unrated: bool = False) -> None:
    """Two groups: EMG at 2000 Hz in V, and, 10 ms later, force at 500 Hz in N; ``unrated``: one without rate."""
    import nptdms

    begun = np.datetime64("2024-01-02T03:04:05.000000")
    emg = {"wf_increment": 1 / 2000, "wf_start_offset": 0.0, "wf_start_time": begun, "unit_string": "mV"}
    later = begun + np.timedelta64(10, "ms")
    force = {"wf_increment": 1 / 500, "wf_start_offset": 0.001, "wf_start_time": later, "NI_UnitDescription": "N"}
    channels = [
        nptdms.ChannelObject("EMG box", "EDC", wave(4 * N, 1), properties=emg),
        nptdms.ChannelObject("Plate", "Fz", wave(N, 2), properties=force),
        nptdms.ChannelObject("Plate", "words", ["a", "b"]),
        nptdms.ChannelObject("Decimated Data_Level 1", "EDC", wave(4, 1)),
    ]
    with nptdms.TdmsWriter(path) as writer:
        writer.write_segment([*channels, nptdms.ChannelObject("Plate", "EDC", wave(N, 3))] if unrated else channels)


def save_opensignals_hdf5(path: Path) -> None:
    """Two devices of 1000 and 500 Hz, channels 3 and 1; two samples are lost after the tenth."""
    import h5py

    with h5py.File(path, "w") as file:
        for address, fs_hz, n, k in (("00:A", 1000, N, 3), ("00:B", 500, N // 2, 1)):
            device = file.create_group(address)
            device.attrs.update(
                {"sampling rate": fs_hz, "device": "biosignalsplux", "date": "2020-1-2", "time": "3:4:5"}
            )
            device["raw/nSeq"] = np.concatenate([np.arange(10), np.arange(10, n) + 2]).astype("u2")[:, None]
            device[f"raw/channel_{k}"] = np.arange(n, dtype="u2")[:, None]
            device["support/level_10/channel_1/mean"] = np.zeros((9, 1))


def xdf(uneven: bool = False) -> bytes:
    """Streams: 1 "EMG" 500 Hz with names and units, 2 "Force" 50 Hz, 3 "Events" at 10 Hz, 4 "Markers", 5 "Empty".

    uneven : the time stamps of 3 are.
    """
    labels = "".join(f"<channel><label>{name}</label><unit>microvolts</unit></channel>" for name in ("EDC", "FDS"))
    heads = {
        1: ("EMG", 2, 500, "float32", f"<channels>{labels}</channels>"), 2: ("Force", 1, 50, "double64", ""),
        3: ("Events", 1, 0, "int32", ""), 4: ("Markers", 1, 0, "string", ""), 5: ("Empty", 1, 100, "float32", ""),
    }  # fmt: skip
    parts = [b"XDF:" + xdf_chunk(1, b'<?xml version="1.0"?><info><version>1.0</version></info>')]
    for stream, (name, n_channels, fs_hz, kind, desc) in heads.items():
        info = f"<info><name>{name}</name><type>X</type><channel_count>{n_channels}</channel_count>"
        info += (
            f"<nominal_srate>{fs_hz}</nominal_srate><channel_format>{kind}</channel_format><desc>{desc}</desc></info>"
        )
        parts.append(xdf_chunk(2, struct.pack("<I", stream) + info.encode()))
    emg, force = np.stack([wave(5 * N, 1), wave(5 * N, 2)], axis=1), wave(N // 2, 3)
    samples = {
        1: [(3 + i / 500, row.astype("<f4").tobytes()) for i, row in enumerate(emg)],
        2: [(3.05 + i / 50, struct.pack("<d", value)) for i, value in enumerate(force)],
        3: [
            (3 + t, struct.pack("<i", i))
            for i, t in enumerate((0.0, 0.1, 0.35 if uneven else 0.2, 0.4 if uneven else 0.3))
        ],
        4: [(3.5, b"\1\4stop")],
    }
    parts += [_xdf_samples(stream, rows) for stream, rows in samples.items()]
    parts += [xdf_chunk(6, struct.pack("<I", stream) + b"<info></info>") for stream in heads]
    return b"".join(parts)


def xdf_stream(
    stamps: np.ndarray, samples: np.ndarray, fs_hz: float = 1000, units: Mapping[str, str] | None = None
) -> bytes:
    """One stream "EMG": the samples (n,) or (n, channels) with their time stamps (n,), in seconds.

    units : of each channel by its name; None: one channel without either.
    """
    columns = np.ascontiguousarray(samples, dtype="<f8").reshape(len(stamps), -1)
    labels = [f"<channel><label>{name}</label><unit>{unit}</unit></channel>" for name, unit in (units or {}).items()]
    info = f"<info><name>EMG</name><type>EMG</type><channel_count>{columns.shape[1]}</channel_count>"
    info += f"<nominal_srate>{fs_hz}</nominal_srate><channel_format>double64</channel_format>"
    info += f"<desc><channels>{''.join(labels)}</channels></desc></info>" if labels else "<desc/></info>"
    rows = [(stamp, row.tobytes()) for stamp, row in zip(stamps.tolist(), columns, strict=True)]
    head = xdf_chunk(1, b'<?xml version="1.0"?><info><version>1.0</version></info>')
    end = xdf_chunk(6, struct.pack("<I", 1) + b"<info></info>")
    return b"XDF:" + head + xdf_chunk(2, struct.pack("<I", 1) + info.encode()) + _xdf_samples(1, rows) + end


def _xdf_samples(stream: int, rows: list[tuple[float, bytes]]) -> bytes:
    body = struct.pack("<IBI", stream, 4, len(rows))
    return xdf_chunk(3, body + b"".join(b"\x08" + struct.pack("<d", stamp) + row for stamp, row in rows))


def xdf_chunk(tag: int, content: bytes) -> bytes:
    """A chunk of an XDF file."""
    return struct.pack("<BIH", 4, len(content) + 2, tag) + content


MADE: dict[str, Callable[[], bytes]] = {
    "two_groups.hpf": hpf,
    "version3.emg": demg,
    "one_device.opensignals.txt": opensignals,
    "two_devices_lost.opensignals.txt": lambda: opensignals(lost=True, devices=2),
    "bitalino.opensignals.txt": lambda: opensignals(bitalino=True),
    "no_x.lvm": lvm,
    "one_x.lvm": lambda: lvm("One", 1),
    "multi_x_gap.lvm": lambda: lvm("Multi", 3, gap_s=1.0, decimal="."),
    "nexus.vicon.csv": vicon,
    "block.labchart.txt": labchart,
    "counts.anc": evart,
    "counts.netft.csv": net_ft,
    "bare.emgworks.csv": emgworks,
    "verbose.emgworks.csv": lambda: emgworks(verbose=True),
    "v150.discover.csv": discover,
    "plain.csv": plain_csv,
    "instrument.csv": instrument_csv,
    "matrix.txt": text_matrix,
}
"""Name of a made file to what makes it."""
