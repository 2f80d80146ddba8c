"""A session in real time beside a recorder of its LSL streams: the same samples, and how much later.

Run as ``python -m benchmarks.lsl_outlets``; it prints Markdown. ``emg2vsa session --virtual --speed 1`` is a process
of its own. This one has an inlet of pylsl on each of its streams, writes what comes as LabRecorder does (XDF), reads
that with pyxdf, and compares it with the recordings in BIDS. The added delay of a block of samples is from its arrival
in the session to its arrival here, by one clock.
"""

from __future__ import annotations

import os
import struct
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import edfio
import numpy as np

from benchmarks.bench.record import print_page
from benchmarks.made_recordings import xdf_chunk
from benchmarks.small_study import SIMULATED_SESSION, small_study
from emg2vsa.devices.clock import undisturbed
from emg2vsa.devices.lsl.outlets import SESSION_SOURCE
from emg2vsa.session.journal import JOURNAL_FILE, PLACED, read_journal
from emg2vsa.session.raw_files import SampleFile

PARTICIPANT, TASK, STREAMS = "P03", "press", 5
STUDY = small_study(
    participants=[PARTICIPANT], specimens=["S1", "S5"], task=TASK, simulation="seed = 5\n",
    tables=f"[session]\n{SIMULATED_SESSION}lsl_outlets = true\nrepetitions = 3\npause_s = 1.0\n",
)  # fmt: skip
SIGN = -1
"Of the force in the files of this study."
ALIKE = 60
"Samples by which the place of a recording in a stream is found."


def alone_on_this_computer(folder: Path) -> dict[str, str]:
    """Variables by which LSL finds the streams of this benchmark and no others."""
    config = folder / "lsl_api.cfg"
    peers = "[multicast]\nResolveScope = machine\n[lab]\nKnownPeers = {127.0.0.1}\n"
    config.write_text(f"{peers}SessionID = {folder.name}\n[log]\nlevel = -3\n")
    return {"LSLAPICFG": str(config)}


@dataclass
class Recorded:
    """What came of a stream. chunks : when each came, by the clock of LSL, and after how many samples."""

    inlet: Any
    info: Any
    rows: list[list[Any]] = field(default_factory=list)
    stamps_s: list[float] = field(default_factory=list)
    chunks: list[tuple[float, int]] = field(default_factory=list)

    def follow(self, lsl: Any, over: threading.Event) -> None:
        """Take what comes, at once, until it is over or the sender ends, and nothing is left."""
        while True:
            try:
                row, stamp_s = self.inlet.pull_sample(0.2)
            except lsl.util.LostError:
                return
            if row is not None:
                rows, stamps_s = self.inlet.pull_chunk(0.0, 1 << 14)
                self.rows += [row, *rows]
                self.stamps_s += [stamp_s, *stamps_s]
                self.chunks.append((lsl.local_clock(), len(self.rows)))
            elif over.is_set():
                return


@contextmanager
def recording(lsl: Any, streams: int = STREAMS, wait_s: float = 30.0) -> Iterator[dict[str, Recorded]]:
    """Record every stream of a session; name, without "emg2vsa", to what came of it."""
    end_s, found = time.monotonic() + wait_s, []
    while len(found) < streams and time.monotonic() < end_s:
        found = [each for each in lsl.resolve_streams(1.5) if each.source_id().startswith(SESSION_SOURCE)]
    recorded = {}
    for each in found:
        inlet = lsl.StreamInlet(each, max_buflen=360, recover=False)
        recorded[each.name().removeprefix("emg2vsa ")] = Recorded(inlet, inlet.info(10.0))
        inlet.open_stream(10.0)
    over = threading.Event()
    threads = [threading.Thread(target=own.follow, args=(lsl, over)) for own in recorded.values()]
    for thread in threads:
        thread.start()
    try:
        yield recorded
    finally:
        over.set()
        for thread in threads:
            thread.join()


def xdf_bytes(recorded: dict[str, Recorded]) -> bytes:
    """The file that LabRecorder makes of it."""
    parts = [b"XDF:" + xdf_chunk(1, b'<?xml version="1.0"?><info><version>1.0</version></info>')]
    for number, own in enumerate(recorded.values(), 1):
        stream = struct.pack("<I", number)
        parts.append(xdf_chunk(2, stream + own.info.as_xml().encode()))
        samples = b"".join(
            b"\x08" + struct.pack("<d", stamp_s) + _values(row)
            for row, stamp_s in zip(own.rows, own.stamps_s, strict=True)
        )
        if own.rows:
            parts.append(xdf_chunk(3, stream + b"\4" + struct.pack("<I", len(own.rows)) + samples))
            parts.append(xdf_chunk(4, stream + struct.pack("<dd", own.stamps_s[-1], 0.0)))
        parts.append(xdf_chunk(6, stream + b"<info></info>"))
    return b"".join(parts)


def _values(row: list[Any]) -> bytes:
    if isinstance(row[0], str):
        return b"".join(b"\4" + struct.pack("<I", len(each.encode())) + each.encode() for each in row)
    return np.array(row, dtype="<f4").tobytes()


def read_xdf(path: Path) -> dict[str, tuple[Any, np.ndarray[Any, Any]]]:
    """Name, without "emg2vsa", to values and stamps of each stream, by pyxdf."""
    import pyxdf

    streams, _ = pyxdf.load_xdf(str(path), dejitter_timestamps=False)
    return {
        each["info"]["name"][0].removeprefix("emg2vsa "): (each["time_series"], each["time_stamps"]) for each in streams
    }


def place_of(part: np.ndarray[Any, Any], whole: np.ndarray[Any, Any], step: float) -> int:
    """Where in (n,) ``whole`` the (m,) ``part`` begins, whose values were rounded to ``step``; -1: nowhere."""
    starts = np.arange(len(whole) - len(part) + 1)
    for i in range(min(ALIKE, len(part))):
        starts = starts[np.abs(whole[starts + i] - part[i]) <= step]
    return int(starts[0]) if len(starts) == 1 else -1


def compared(data: Path, streams: dict[str, tuple[Any, np.ndarray[Any, Any]]]) -> Iterator[tuple[str, int, float]]:
    """Of each channel of each recording: its name, samples, and largest difference in steps of the file; NaN: it was
    not found."""
    sent = {"Fz": SIGN * streams["force"][0][:, 0]} | dict(zip(("EDC", "FDS"), streams["EMG"][0].T, strict=True))
    for path in sorted(data.glob(f"sub-{PARTICIPANT}/**/*_emg.bdf")):
        for signal in edfio.read_bdf(path).signals:
            whole, scale = sent[signal.label], {"uV": 1e-6, "N": 1.0}[signal.physical_dimension]
            values = scale * np.trim_zeros(signal.data, "b")  # what fills the last data record
            step = scale * (signal.physical_max - signal.physical_min) / (signal.digital_max - signal.digital_min)
            at = place_of(values, np.asarray(whole, dtype=float), step)
            difference = np.abs(whole[at : at + len(values)] - values).max() / step if at >= 0 else np.nan
            yield f"{path.stem.removesuffix('_emg')}, {signal.label}", len(values), float(difference)


def delays_ms(folder: Path, recorded: dict[str, Recorded], name: str) -> np.ndarray[Any, Any]:
    """Of each block of samples from its arrival in the session to its arrival in the recorder."""
    lines, _ = read_journal(folder / JOURNAL_FILE)
    placed_s = next(line.time_s for line in lines if getattr(line.event, "item", "") == PLACED)
    markers = recorded["markers"]
    offset_s = markers.stamps_s[[text.startswith("specimen") for (text,) in markers.rows].index(True)] - placed_s
    file = SampleFile(folder / f"sitting-1_{name.lower()}.samples")
    kept = file.read(0, file.stop)[:, 0]
    came = np.array(recorded[name].rows, dtype=np.float64)[:, 0]
    first = place_of(came, kept, 0.0)
    ends = file.blocks.first + file.blocks.count
    counts = np.array([count for _, count in recorded[name].chunks])
    times_s = np.array([time_s for time_s, _ in recorded[name].chunks])
    known = (ends > first) & (ends - first <= counts[-1])
    came_s = times_s[np.searchsorted(counts, ends[known] - first)]
    return np.asarray(1e3 * (came_s - offset_s - file.blocks.arrived_s[known]))


def page() -> Iterator[str]:
    with tempfile.TemporaryDirectory(prefix="lsl_outlets_") as folder:
        yield from _page(Path(folder))


def _page(folder: Path) -> Iterator[str]:
    os.environ |= alone_on_this_computer(folder)
    import pylsl

    (folder / "study.toml").write_text(STUDY)
    busy = os.getloadavg()[0]
    command = [sys.executable, "-m", "emg2vsa.cli", "session", "study.toml", "--participant", PARTICIPANT]
    with subprocess.Popen(
        [*command, "--virtual", "--no-page", "--speed", "1"], cwd=folder, text=True,
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
    ) as session, undisturbed(), recording(pylsl) as recorded:  # fmt: skip
        said, _ = session.communicate(timeout=600)
    if session.returncode or len(recorded) < STREAMS:
        raise SystemExit(f"streams: {', '.join(recorded)}\n{said}")
    (folder / "recorded.xdf").write_bytes(xdf_bytes(recorded))
    streams = read_xdf(folder / "recorded.xdf")
    yield "# LSL streams of a session\n"
    yield __doc__.partition("\n\n")[2].replace("``", "`")
    yield f"Load of the two cores {busy:.1f} before, {os.getloadavg()[0]:.1f} after.\n"
    yield "| added delay | blocks | p50, ms | p95, ms | p99, ms | largest, ms |"
    yield "|---|---:|---:|---:|---:|---:|"
    raw = folder / "data" / "sourcedata" / f"sub-{PARTICIPANT}" / TASK
    for name in ("force", "EMG"):
        delays = delays_ms(raw, recorded, name)
        figures = (*np.percentile(delays, (50, 95, 99)), delays.max())
        yield f"| {name} | {len(delays)} | {' | '.join(f'{ms:.2f}' for ms in figures)} |"
    yield "\n| recording in BIDS beside the XDF file | samples | largest difference, steps of the BDF file |"
    yield "|---|---:|---:|"
    for name, samples, steps in compared(folder / "data", streams):
        yield f"| {name} | {samples} | {steps:.2f} |"
    words = [row[0].partition(" ")[0] for name in ("markers", "verdicts") for row in streams[name][0]]
    yield f"\nMarkers and verdicts: {', '.join(f'{words.count(word)} {word}' for word in dict.fromkeys(words))}.\n"


if __name__ == "__main__":
    print_page(__doc__, page)
