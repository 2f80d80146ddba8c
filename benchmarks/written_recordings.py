"""One recording of two EMG channels and force, written by the libraries of several formats."""

from __future__ import annotations

from pathlib import Path

import edfio
import ezc3d
import numpy as np
import pandas as pd
import scipy.io

from benchmarks.made_recordings import xdf_stream

NAMES = ("EDC", "FDS", "Fz")
FS_HZ = 1000.0
UNITS = {"EDC": "V", "FDS": "V", "Fz": "N"}
Samples = dict[str, np.ndarray]


def made_samples(n: int) -> Samples:
    """EMG in volts and force in newtons, (n,) each, n a multiple of 1000."""
    rng = np.random.default_rng(0)
    return {"EDC": 50e-6 * rng.normal(size=n), "FDS": 80e-6 * rng.normal(size=n), "Fz": 3 + rng.normal(size=n)}


def write_bdf(folder: Path, truth: Samples) -> Path:
    """EMG in uV, as amplifiers write it."""
    path = folder / "a.bdf"
    emg = [edfio.BdfSignal(1e6 * truth[k], FS_HZ, label=k, physical_dimension="uV") for k in NAMES[:2]]
    edfio.Bdf([*emg, edfio.BdfSignal(truth["Fz"], FS_HZ, label="Fz", physical_dimension="N")]).write(path)
    return path


def write_edf(folder: Path, truth: Samples) -> Path:
    path = folder / "a.edf"
    emg = [edfio.EdfSignal(1e6 * truth[k], FS_HZ, label=k, physical_dimension="uV") for k in NAMES[:2]]
    edfio.Edf([*emg, edfio.EdfSignal(truth["Fz"], FS_HZ, label="Fz", physical_dimension="N")]).write(path)
    return path


def write_csv(folder: Path, truth: Samples) -> Path:
    path = folder / "a.csv"
    time_s = np.arange(truth["Fz"].size) / FS_HZ
    table = pd.DataFrame({"time (s)": time_s, **{f"{k} ({UNITS[k]})": truth[k] for k in NAMES}})
    table.to_csv(path, index=False, float_format="%.9g")
    return path


def write_c3d(folder: Path, truth: Samples) -> Path:
    path = folder / "a.c3d"
    file = ezc3d.c3d()
    file["parameters"]["POINT"]["RATE"]["value"] = [FS_HZ / 10]
    file["parameters"]["ANALOG"]["RATE"]["value"] = [FS_HZ]
    file["parameters"]["ANALOG"]["LABELS"]["value"] = list(NAMES)
    file["parameters"]["ANALOG"]["UNITS"]["value"] = list(UNITS.values())
    file["data"]["points"] = np.zeros((4, 0, truth["Fz"].size // 10))
    file["data"]["analogs"] = np.stack([truth[k] for k in NAMES])[np.newaxis]
    file.write(str(path))
    return path


def write_mat(folder: Path, truth: Samples) -> Path:
    path = folder / "a.mat"
    scipy.io.savemat(path, {**truth, "fs": FS_HZ})
    return path


def write_tdms(folder: Path, truth: Samples) -> Path:
    """Raises ImportError without nptdms."""
    import nptdms

    path = folder / "a.tdms"
    rate = {"wf_increment": 1 / FS_HZ, "wf_start_offset": 0.0}
    with nptdms.TdmsWriter(path) as writer:
        writer.write_segment(
            [nptdms.ChannelObject("box", k, truth[k], properties=rate | {"unit_string": UNITS[k]}) for k in NAMES]
        )
    return path


def write_xdf(folder: Path, truth: Samples) -> Path:
    """Three channels of one stream, with a time stamp at each sample."""
    path = folder / "a.xdf"
    stamps = np.arange(truth["Fz"].size) / FS_HZ
    path.write_bytes(xdf_stream(stamps, np.stack([truth[k] for k in NAMES], axis=1), FS_HZ, UNITS))
    return path
