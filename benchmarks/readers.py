"""Time and error of reading one recording of the study's size, against the libraries a user would reach for.

Run as ``python -m benchmarks.readers``: 70 s of two EMG channels and force at 1000 Hz, as BDF, CSV and C3D.
BDF, CSV and C3D are decoded by edfio, pandas and ezc3d: the difference to their own rows is what validation, units and
a copy that can be changed cost. Two more tables say what the child process of foreign decoders costs once it is warm:
for files of each format by size, and for the frames of a video. Those times are processor times of both processes, the
best of several; results/decoder_process.md holds a run. The times of the first table are wall times.
"""

from __future__ import annotations

import importlib
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import cv2
import edfio
import ezc3d
import mne
import numpy as np
import pandas as pd
import scipy.io

from casr.decoder_process import child_pid
from casr.frame_files import open_frames
from casr.frame_files.video import VideoDecoder
from casr.frames import FrameSequence
from casr.scoring import score
from casr.synthetic.press import simulate_press
from casr.synthetic.settings import PressSettings, TimelineSettings
from casr.synthetic.write import write_press
from emg2vsa.readers.formats import head_of, reader_of
from emg2vsa.readers.front_door import open_recording, read
from emg2vsa.readers.opened import OpenRecording

NAMES = ("EDC", "FDS", "Fz")
FS_HZ, N = 1000.0, 70_000
REPEATS = 15

Samples = dict[str, np.ndarray]


def main() -> None:
    mne.set_log_level("error")
    rng = np.random.default_rng(0)
    truth = {"EDC": 50e-6 * rng.normal(size=N), "FDS": 80e-6 * rng.normal(size=N), "Fz": 3 + rng.normal(size=N)}
    with tempfile.TemporaryDirectory() as folder:
        bdf, csv, c3d = _write(Path(folder), truth)
        cases: list[tuple[str, Callable[[], Samples]]] = [
            ("BDF  emg2vsa", lambda: _ours(bdf)),
            ("BDF  emg2vsa, one channel", lambda: _ours(bdf, ("Fz",))),
            ("BDF  edfio .data", lambda: _edfio(bdf)),
            ("BDF  mne", lambda: _mne(bdf)),
            ("CSV  emg2vsa", lambda: _ours(csv)),
            ("CSV  emg2vsa, one channel", lambda: _ours(csv, ("Fz",))),
            ("CSV  pandas, all columns", lambda: _pandas(csv)),
            ("C3D  emg2vsa", lambda: _ours(c3d)),
            ("C3D  ezc3d", lambda: _ezc3d(c3d)),
        ]
        _table(cases, truth)
        print("\n" + child_cost_table(Path(folder)))
        print("\n" + video_cost_table(Path(folder)))


def child_cost_table(folder: Path, sizes: tuple[int, ...] = (10_000, 100_000, 1_000_000)) -> str:
    """Time of opening a file and loading all channels, in this process and through the warm child, in Markdown."""
    lines = ["| format | MB | here ms | child ms | more ms | allowed ms |", "|---|---:|---:|---:|---:|---:|"]
    for n in sizes:
        for path in _of_size(folder, n):
            reader = reader_of(path, head_of(path))
            assert reader is not None
            module = reader.module
            here, child = _alternately(
                lambda module=module, path=path: _load_all(importlib.import_module(module).open_recording(path)),
                lambda path=path: _load_all(open_recording(path)[1]),
            )
            size_mb = path.stat().st_size / 1e6
            lines.append(
                f"| {path.suffix[1:]} | {size_mb:.2f} | {1e3 * here:.1f} | {1e3 * child:.1f} "
                f"| {1e3 * (child - here):.1f} | {20 + size_mb:.1f} |"
            )
    return "\n".join(lines)


def _of_size(folder: Path, n: int) -> list[Path]:
    rng = np.random.default_rng(0)
    truth = {name: rng.normal(size=n) for name in NAMES}
    edf = folder / "a.edf"
    edfio.Edf([edfio.EdfSignal(x, FS_HZ, label=k, physical_dimension="N") for k, x in truth.items()]).write(edf)
    scipy.io.savemat(folder / "a.mat", {**truth, "fs": FS_HZ})
    bdf, _, c3d = _write(folder, truth, csv=False)
    return [edf, bdf, c3d, folder / "a.mat"]


def _load_all(opened: OpenRecording) -> None:
    opened.load(range(len(opened.describe())))


def video_cost_table(folder: Path) -> str:
    """Time of scoring the frames of a video, decoded in this process and in the child, in Markdown."""
    press = write_press(simulate_press(PressSettings(timeline=TimelineSettings(loading_s=6.0))), folder / "press")
    frames = open_frames(press)
    path = folder / "press.avi"
    size = frames.shape[1], frames.shape[0]
    video = cv2.VideoWriter(str(path), cv2.CAP_FFMPEG, cv2.VideoWriter_fourcc(*"FFV1"), 20, size, True)
    for frame in frames:
        video.write(cv2.cvtColor(frame, cv2.COLOR_GRAY2BGR))
    video.release()
    beside = {"force": press / "force.csv", "camera": press / "camera.toml"}
    in_child = open_frames(path, **beside)

    def here() -> FrameSequence:
        decoder = VideoDecoder(path)
        decoder.name = "press"
        return replace(in_child, source=decoder)

    lines = [f"| {len(frames)} frames, {size[0]} x {size[1]} | here s | child s | more % |", "|---|---:|---:|---:|"]
    for name, work in (("decoded", list), ("decoded and scored", score)):
        here_s, child_s = _alternately(
            lambda work=work: work(here()), lambda work=work: work(open_frames(path, **beside))
        )
        lines.append(f"| {name} | {here_s:.3f} | {child_s:.3f} | {100 * (child_s / here_s - 1):.1f} |")
    return "\n".join(lines)


def _alternately(*ways: Callable[[], object]) -> list[float]:
    """Least processor time of each, this process and the child together, after one run that warms it up, s."""
    best = [float("inf")] * len(ways)
    for repeat in range(REPEATS + 1):
        for i, way in enumerate(ways):
            start = _processor_s()
            way()
            best[i] = min(best[i], _processor_s() - start) if repeat else best[i]
    return best


def _processor_s() -> float:
    """Processor time so far of this process and of the child (Linux)."""
    pid = child_pid()
    return time.process_time() + (time.clock_gettime(~pid << 3 | 2) if pid else 0.0)  # clock_getcpuclockid(3)


def _table(cases: list[tuple[str, Callable[[], Samples]]], truth: Samples) -> None:
    errors = [
        max(float(np.abs(s - truth[k]).max() / np.abs(truth[k]).max()) for k, s in run().items()) for _, run in cases
    ]
    best = [float("inf")] * len(cases)
    for _ in range(REPEATS):
        for i, (_, run) in enumerate(cases):
            start = time.perf_counter()
            run()
            best[i] = min(best[i], time.perf_counter() - start)
    ours: dict[str, float] = {}
    print(f"{'reader':28} {'ms/file':>8} {'x ours':>7} {'error / range':>14}")
    for (name, _), seconds, error in zip(cases, best, errors, strict=True):
        base = ours.setdefault(name[:3], seconds)
        print(f"{name:28} {1e3 * seconds:8.2f} {seconds / base:7.2f} {error:14.1e}")


def _write(folder: Path, truth: Samples, csv: bool = True) -> tuple[Path, Path, Path]:
    n = truth["Fz"].size
    emg = [edfio.BdfSignal(1e6 * truth[k], FS_HZ, label=k, physical_dimension="uV") for k in NAMES[:2]]
    edfio.Bdf([*emg, edfio.BdfSignal(truth["Fz"], FS_HZ, label="Fz", physical_dimension="N")]).write(folder / "a.bdf")
    if csv:
        names = {"EDC": "EDC (V)", "FDS": "FDS (V)", "Fz": "Fz (N)"}
        table = pd.DataFrame({"time (s)": np.arange(n) / FS_HZ, **{names[k]: truth[k] for k in NAMES}})
        table.to_csv(folder / "a.csv", index=False, float_format="%.9g")
    file = ezc3d.c3d()
    file["parameters"]["POINT"]["RATE"]["value"] = [FS_HZ / 10]
    file["parameters"]["ANALOG"]["RATE"]["value"] = [FS_HZ]
    file["parameters"]["ANALOG"]["LABELS"]["value"] = list(NAMES)
    file["parameters"]["ANALOG"]["UNITS"]["value"] = ["V", "V", "N"]
    file["data"]["points"] = np.zeros((4, 0, n // 10))
    file["data"]["analogs"] = np.stack([truth[k] for k in NAMES])[np.newaxis]
    file.write(str(folder / "a.c3d"))
    return folder / "a.bdf", folder / "a.csv", folder / "a.c3d"


def _ours(path: Path, names: tuple[str, ...] = NAMES) -> Samples:
    return {channel.name: channel.samples for channel in read(path, names).channels}


def _edfio(path: Path) -> Samples:
    file = edfio.read_bdf(path)
    return {k: file.get_signal(k).data * (1.0 if k == "Fz" else 1e-6) for k in NAMES}


def _mne(path: Path) -> Samples:
    return dict(zip(NAMES, mne.io.read_raw_bdf(path, preload=True).get_data(picks=list(NAMES)), strict=True))


def _pandas(path: Path) -> Samples:
    table = pd.read_csv(path)
    return {column.partition(" ")[0]: table[column].to_numpy() for column in table.columns[1:]}


def _ezc3d(path: Path) -> Samples:
    return dict(zip(NAMES, ezc3d.c3d(str(path))["data"]["analogs"][0], strict=True))


if __name__ == "__main__":
    main()
