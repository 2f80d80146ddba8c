"""Time and error of reading one recording of the study's size, against the libraries a user would reach for.

Run as ``python -m benchmarks.readers``: 70 s of two EMG channels and force at 1000 Hz, as BDF, CSV and C3D.
BDF, CSV and C3D are decoded by edfio, pandas and ezc3d: the difference to their own rows is what validation, units and
a copy that can be changed cost.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import edfio
import ezc3d
import mne
import numpy as np
import pandas as pd

from emg2vsa.readers.front_door import read

NAMES = ("EDC", "FDS", "Fz")
FS_HZ, N = 1000.0, 70_000
REPEATS = 9

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


def _table(cases: list[tuple[str, Callable[[], Samples]]], truth: Samples) -> None:
    errors = [
        max(float(np.abs(s - truth[k]).max() / np.abs(truth[k]).max()) for k, s in run().items()) for _, run in cases
    ]
    best = [float("inf")] * len(cases)
    for _ in range(REPEATS):
        for i, (_, run) in enumerate(cases):
            start = time.process_time()
            run()
            best[i] = min(best[i], time.process_time() - start)
    ours: dict[str, float] = {}
    print(f"{'reader':28} {'ms/file':>8} {'x ours':>7} {'error / range':>14}")
    for (name, _), seconds, error in zip(cases, best, errors, strict=True):
        base = ours.setdefault(name[:3], seconds)
        print(f"{name:28} {1e3 * seconds:8.2f} {seconds / base:7.2f} {error:14.1e}")


def _write(folder: Path, truth: Samples) -> tuple[Path, Path, Path]:
    emg = [edfio.BdfSignal(1e6 * truth[k], FS_HZ, label=k, physical_dimension="uV") for k in NAMES[:2]]
    edfio.Bdf([*emg, edfio.BdfSignal(truth["Fz"], FS_HZ, label="Fz", physical_dimension="N")]).write(folder / "a.bdf")
    table = pd.DataFrame(
        {"time (s)": np.arange(N) / FS_HZ, "EDC (V)": truth["EDC"], "FDS (V)": truth["FDS"], "Fz (N)": truth["Fz"]}
    )
    table.to_csv(folder / "a.csv", index=False, float_format="%.9g")
    file = ezc3d.c3d()
    file["parameters"]["POINT"]["RATE"]["value"] = [FS_HZ / 10]
    file["parameters"]["ANALOG"]["RATE"]["value"] = [FS_HZ]
    file["parameters"]["ANALOG"]["LABELS"]["value"] = list(NAMES)
    file["parameters"]["ANALOG"]["UNITS"]["value"] = ["V", "V", "N"]
    file["data"]["points"] = np.zeros((4, 0, N // 10))
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
