"""Recordings of every binary and text format beside the format's own library, and a video decoded in the child.

The recordings, of two EMG channels and force, are written by the libraries of the formats.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable, Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import edfio
import ezc3d
import numpy as np
import pandas as pd
import scipy.io

from benchmarks.bench.case import Area, Case, Size, Way, peer
from benchmarks.experts import files
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


Samples = dict[str, np.ndarray]
_FOLDERS: list[TemporaryDirectory[str]] = []
"Kept until the process ends, for ways are run after the cases are made."


def files_of_formats(size: Size) -> Iterator[Case]:
    """A recording of the study's size: 70 s of two EMG channels and force at 1000 Hz."""
    folder, n = _folder(), size.pick(7_000, 70_000)
    truth = made_samples(n)
    yield _case("BDF", write_bdf(folder, truth), truth, _edf_peers)
    yield _case("EDF", write_edf(folder, truth), truth, _edf_peers)
    yield _case("CSV", write_csv(folder, truth), truth, _csv_peers)
    yield _case("C3D", write_c3d(folder, truth), truth, _c3d_peers)
    yield _case("MATLAB", write_mat(folder, truth), truth, _mat_peers)
    if peer("nptdms"):
        yield _case("TDMS", write_tdms(folder, truth), truth, _tdms_peers)
    if peer("pyxdf"):
        yield _case("XDF", write_xdf(folder, truth), truth, _xdf_peers, stream="EMG: ")


def growth_with_length(size: Size) -> Iterator[Case]:
    """BDF files of growing length: what the child process costs is a share of the file, and a constant."""
    for n in size.pick((2_000, 4_000), (10_000, 100_000, 1_000_000)):
        folder, truth = _folder(), made_samples(n)
        yield _case(f"BDF, {n} samples", write_bdf(folder, truth), truth, _edf_peers, "BDF by length")


def one_channel(size: Size) -> Iterator[Case]:
    """One of three channels of a file."""
    folder, n = _folder(), size.pick(7_000, 70_000)
    truth = made_samples(n)
    path = write_bdf(folder, truth)
    ways = [
        Way("emg2vsa", "read, one channel", lambda: _ours(path, ("Fz",)), "equal", CHILD),
        Way("numpy", EXPERT, lambda: files.edf(path, ("Fz",)), "equal", "no annotations, no child process"),
    ]
    if edfio := peer("edfio"):
        ways.append(Way("edfio", "get_signal", lambda: {"Fz": edfio.read_bdf(path).get_signal("Fz").data}, "equal"))
    if mne := peer("mne"):

        def by_mne() -> Samples:
            raw = mne.io.read_raw_bdf(path, include=["Fz"], preload=True, verbose="error")
            return {"Fz": raw.get_data()[0]}

        ways.append(Way("MNE", "read_raw_bdf, include", by_mne, "equal"))
    yield _as_case("BDF, force alone", path, tuple(ways), {"Fz": truth["Fz"]})


def video(size: Size) -> Iterator[Case]:
    """Frames of a lossless video."""
    import cv2

    from casr.frame_files.video import VideoDecoder, open_file

    path, frames = _film(_folder(), size.pick(10, 141))

    def by_child() -> np.ndarray:
        film = open_file(path)
        return np.array([film.read(i) for i in range(len(frames))])

    def here() -> np.ndarray:
        decoder = VideoDecoder(path)
        return np.array([decoder.read(i) for i in range(len(frames))])

    def by_opencv() -> np.ndarray:
        capture = cv2.VideoCapture(str(path))
        read = [capture.read()[1] for _ in range(len(frames))]
        return np.array([cv2.cvtColor(frame, cv2.COLOR_BGR2GRAY) for frame in read])

    yield Case(
        f"lossless video of {len(frames)} frames",
        len(frames),
        "frames",
        (
            Way("casr", "video.open_file", by_child, "equal", CHILD),
            Way("casr", "VideoDecoder in this process", here, "equal"),
            Way("OpenCV", "VideoCapture", by_opencv, "equal", "checks nothing"),
        ),
        lambda found: float(np.max(np.abs(found.astype(float) - frames))),
        "grey levels",
        "the frames that were written",
    )


EXPERT = "expert: bytes of one read"
CHILD = "in the child process, whose processor time counts"


def _case(
    name: str, path: Path, truth: Samples, peers: Callable[[Path], Iterator[Way]], family: str = "", stream: str = ""
) -> Case:
    """stream : what our reader puts before the name of a channel."""
    from emg2vsa.readers.formats import head_of, reader_of
    from emg2vsa.readers.opened import to_si

    reader = reader_of(path, head_of(path))
    assert reader is not None

    def here() -> Samples:
        opened = importlib.import_module(reader.module).open_recording(path)
        stored = opened.load(range(len(opened.describe())))
        return {channel.name.removeprefix(stream): to_si(channel).samples for channel in stored}

    ways = [Way("emg2vsa", "read", lambda: _ours(path, stream=stream), "equal", CHILD if reader.library else "")]
    if reader.library:
        ways.append(Way("emg2vsa", "read in this process", here, "equal"))
    return _as_case(name, path, (*ways, *peers(path)), truth, family)


def _as_case(name: str, path: Path, ways: tuple[Way, ...], truth: Samples, family: str = "") -> Case:
    def error(found: Samples) -> float:
        return max(float(np.max(np.abs(found[name] - samples)) / np.ptp(samples)) for name, samples in truth.items())

    unit = "of the range of a channel"
    return Case(
        name, round(path.stat().st_size / 1e6, 2), "MB", ways, error, unit, "the samples that were written", family
    )


def _ours(path: Path, names: tuple[str, ...] = NAMES, stream: str = "") -> Samples:
    from emg2vsa.readers.front_door import read

    found = read(path, tuple(stream + name for name in names)).channels
    return {channel.name.removeprefix(stream): channel.samples for channel in found}


def _edf_peers(path: Path) -> Iterator[Way]:
    """Of EDF and of BDF."""
    kind = path.suffix[1:]
    yield Way("numpy", EXPERT, lambda: files.edf(path, NAMES), "equal", "no annotations, no child process")
    if edfio := peer("edfio"):
        own = getattr(edfio, f"read_{kind}")
        yield Way("edfio", f"read_{kind}", lambda: _edfio(own(path)), "equal", "no checks of the file")
    if mne := peer("mne"):
        raw = getattr(mne.io, f"read_raw_{kind}")
        yield Way("MNE", f"read_raw_{kind}", lambda: _mne(raw(path, preload=True, verbose="error")), "equal")


def _edfio(file: Any) -> Samples:
    return {name: file.get_signal(name).data * (1.0 if name == "Fz" else 1e-6) for name in NAMES}


def _mne(raw: Any) -> Samples:
    return dict(zip(NAMES, raw.get_data(picks=list(NAMES)), strict=True))


def _csv_peers(path: Path) -> Iterator[Way]:
    def samples(table: np.ndarray) -> Samples:
        return dict(zip(NAMES, table.T[1:], strict=True))

    yield Way("pandas", "expert: columns by the parser in C", lambda: files.csv(path, NAMES), "equal", "no units")
    yield Way("numpy", "loadtxt", lambda: samples(np.loadtxt(path, delimiter=",", skiprows=1)), "equal", PLAIN)
    if pandas := peer("pandas"):
        yield Way("pandas", "read_csv", lambda: samples(pandas.read_csv(path).to_numpy()), "equal", PLAIN)


PLAIN = "no units, no rate, no check of the time column"


def _c3d_peers(path: Path) -> Iterator[Way]:
    if ezc3d := peer("ezc3d"):

        def by_ezc3d() -> Samples:
            return dict(zip(NAMES, ezc3d.c3d(str(path))["data"]["analogs"][0], strict=True))

        yield Way("ezc3d", "c3d", by_ezc3d, "equal")


def _mat_peers(path: Path) -> Iterator[Way]:
    scipy_io = peer("scipy.io")

    def by_scipy() -> Samples:
        found = scipy_io.loadmat(path)
        return {name: found[name].ravel() for name in NAMES}

    yield Way("scipy", "io.loadmat", by_scipy, "equal", "no units, no rate")


def _tdms_peers(path: Path) -> Iterator[Way]:
    nptdms = peer("nptdms")

    def by_nptdms() -> Samples:
        file = nptdms.TdmsFile.read(path)
        return {name: file["box"][name][:] for name in NAMES}

    yield Way("npTDMS", "TdmsFile.read", by_nptdms, "equal", "no units, no rate")


def _xdf_peers(path: Path) -> Iterator[Way]:
    pyxdf = peer("pyxdf")

    def by_pyxdf() -> Samples:
        return dict(zip(NAMES, pyxdf.load_xdf(str(path))[0][0]["time_series"].T, strict=True))

    yield Way("pyxdf", "load_xdf", by_pyxdf, "equal", "smooths time stamps, tells no lost samples")


def _film(folder: Path, n: int) -> tuple[Path, np.ndarray]:
    import cv2

    from emg2vsa.worlds.tactile import PressSettings, TimelineSettings, simulate_press

    press = simulate_press(PressSettings(timeline=TimelineSettings(loading_s=max(1.0, n / 20))))
    frames = np.array([press.frames.read(i) for i in range(n)])
    path = folder / "press.avi"
    shape = frames.shape[2], frames.shape[1]
    film = cv2.VideoWriter(str(path), cv2.CAP_FFMPEG, cv2.VideoWriter_fourcc(*"FFV1"), 20, shape, True)
    for frame in frames:
        film.write(cv2.cvtColor(frame, cv2.COLOR_GRAY2BGR))
    film.release()
    return path, frames.astype(float)


def _folder() -> Path:
    _FOLDERS.append(TemporaryDirectory(prefix="emg2vsa-readers-"))
    return Path(_FOLDERS[-1].name)


AREA = Area(
    name="readers",
    question="What does reading a recording cost beside the format's own library, and are the samples right?",
    parts=(files_of_formats, one_channel, growth_with_length, video),
    peers={
        "edfio": "edfio",
        "mne": "mne",
        "pandas": "pandas",
        "ezc3d": "ezc3d",
        "nptdms": "npTDMS",
        "pyxdf": "pyxdf",
    },
    meaning=(
        "C3D, MATLAB, TDMS and XDF files are decoded by ezc3d, SciPy, npTDMS and pyxdf; of EDF and BDF edfio reads the "
        "header, and ours the samples of the channels asked for. The difference between the libraries' own rows and "
        "ours in this process is what checks, units and a copy that may be changed cost; the difference to the first "
        "row is the child process, which keeps a decoder that crashes or never ends away from a run (decision 19). An "
        "error of the size of one quantum of the format (BDF 6e-8, EDF 2e-5 of the range) is that of the file. The "
        "expert's rows decode the bytes of one read of EDF and BDF: ours in this process decodes a BDF faster, and is "
        "slower where the checks of the header cost more than the samples, in a short file or an EDF. C3D, MATLAB, "
        "TDMS, XDF and video have no row of an expert: the formats' own libraries decode them, and ours uses the same."
    ),
)
