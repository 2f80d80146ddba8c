"""Recordings and runs of the rig as NWB files, through pynwb, an optional package.

A recording becomes one file: an electrical series in volts for each muscle and the force in newtons, each at its own
rate and as it was recorded, missing samples NaN; its presses are the trials. A run becomes one file: columns of its log
with their times, its presses as trials, its phases as intervals, its frames as image series, its plan as notes.
"""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Sequence
from datetime import UTC, datetime, timedelta
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from hdmf.backends.hdf5 import H5DataIO
from hdmf.data_utils import DataChunkIterator
from pynwb import NWBHDF5IO, NWBFile, TimeSeries
from pynwb.ecephys import ElectricalSeries
from pynwb.epoch import TimeIntervals
from pynwb.file import Subject
from pynwb.image import ImageSeries

from casr.errors import CasrError
from casr.frame_files import find_presses, open_frames
from casr.frames import FrameSequence
from emg2vsa import __version__
from emg2vsa.bids.names import visit_folder
from emg2vsa.bids.recording import muscle_name
from emg2vsa.errors import DataError
from emg2vsa.pipeline.bids_export import Taken, Writer
from emg2vsa.readers.opened import unique_names
from emg2vsa.recordings import Channel
from emg2vsa.rig.record.new_folder import EMULATED_FILE, PLAN_FILE
from emg2vsa.rig.record.press_counts import PRESSES_FILE
from emg2vsa.rig.record.run_log import read_log
from emg2vsa.run_folders.documents import document
from emg2vsa.study import Person

_UNKNOWN_START = datetime(1970, 1, 1, tzinfo=UTC)
"""NWB wants a start. What states none gets this one, and says so."""
_SEXES = {"m": "M", "male": "M", "f": "F", "female": "F", "o": "O", "other": "O"}
_UNITS = {
    "n": "newtons", "nm": "newton meters", "deg": "degrees", "ticks": "ticks", "ma": "milliamperes", "a": "amperes",
    "s": "seconds",
}  # fmt: skip
"""Units by the end of a column's name."""
_COMMANDED = re.compile(r"(position|preset)(_|$)")
_FRAMES_AT_ONCE = 16


def nwb_writer(people: Sequence[Person] = ()) -> Writer:
    """people : of whom age, sex or hand are known."""
    return Writer(partial(_write_recording, people), write_run)


def _write_recording(people: Sequence[Person], folder: Path, taken: Taken) -> list[Path]:
    """The file of a recording below ``folder``."""
    entry, part = taken.entry, taken.part
    sources = [path for path in (part.emg_file, part.force_file) if path is not None]
    start, told = _start(taken.roles.began, taken.start_s)
    said = f"Surface EMG and pressing force of a person who pressed the specimen {entry.specimen or 'n/a'}. {told}"
    file = _file(
        said.strip(), sources, start, session_id=taken.name.stem,
        notes="\n".join([f"Converted from {', '.join(path.name for path in sources)}.", *taken.roles.notes]),
    )  # fmt: skip
    person = next((one for one in people if one.participant == entry.participant), Person(entry.participant))
    file.subject = _subject(taken.name.participant, person)
    made = [str(taken.further[key]) for key in ("Manufacturer", "ManufacturersModelName") if key in taken.further]
    device = file.create_device("amplifier", description=" ".join(made) or "amplifier of the EMG, not stated")
    distance = f", {taken.about.electrode_mm:g} mm apart" if taken.about.electrode_mm else ""
    names = unique_names([re.sub(r"[/:]", "_", role) for role in taken.roles.emg])
    for i, (name, (role, channel)) in enumerate(zip(names, taken.roles.emg.items(), strict=True)):
        where = f"belly of the {muscle_name(role)}"
        group = file.create_electrode_group(name, f"a pair of surface electrodes{distance}", where, device)
        file.add_electrode(location=where, group=group)
        region = file.create_electrode_table_region([i], f"the pair over the {muscle_name(role)}")
        file.add_acquisition(ElectricalSeries(name=name, electrodes=region, **_samples(channel, taken.start_s)))
    file.add_acquisition(
        TimeSeries(name="pressing_force", unit="newtons", **_samples(taken.roles.force, taken.start_s))
    )
    _add_presses(file, taken)
    path = visit_folder(folder, taken.name.participant, taken.name.visit) / f"{taken.name.stem}.nwb"
    _write(path, file)
    return [path]


def write_run(out: Path, folder: Path) -> Path:
    """The file of a run of the rig, below ``out``. DataError: ``folder`` is none, or its frames cannot be read."""
    folder = folder.resolve()
    path = out / "runs" / f"{folder.name}.nwb"
    try:
        _write(path, _run(folder))
    except CasrError as error:  # frames are decoded when they are written
        path.unlink(missing_ok=True)
        raise DataError(error.where, wanted=error.wanted, found=error.found, do=error.do) from error
    return path


def _run(folder: Path) -> NWBFile:
    try:
        log = read_log(folder / "log.csv")
        plan = json.loads((folder / PLAN_FILE).read_text(encoding="utf-8"))
        started = datetime.fromisoformat(plan["clock"]["zero_utc"])
        about = plan["plan"]
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise DataError(
            folder, wanted="a run of the rig, with plan.json and log.csv", found=str(error) or type(error).__name__,
            do="Choose the folder of a run.",
        ) from error  # fmt: skip
    maker = "An emulated rig" if (folder / EMULATED_FILE).is_file() else "A variable stiffness actuator"
    how = document(folder / "ended.json").get("how", "in an unknown way")
    file = _file(
        f"{maker} pressed a tactile sensor on {about.get('specimen')}, at {about.get('angle_deg')} degrees, under the "
        f"condition {about.get('condition')}; the run ended: {how}.",
        [folder / PLAN_FILE, folder / "log.csv"], started, session_id=folder.name, notes=json.dumps(plan, indent=1),
    )  # fmt: skip
    _add_log(file, log)
    _add_trials(file, folder)
    for path in find_presses(folder) if any(folder.glob("press-*/frames*")) else ():
        file.add_acquisition(_frames(path.name, open_frames(path)))
    return file


def _file(said: str, sources: Sequence[Path], start: datetime, **more: str) -> NWBFile:
    digest = hashlib.sha256()
    for source in sources:
        with source.open("rb") as opened:
            digest.update(hashlib.file_digest(opened, "sha256").digest())
    return NWBFile(
        said, digest.hexdigest()[:32], start, keywords=["EMG", "force", "touch"], source_script="emg2vsa tools convert",
        experiment_description="Softness by touch: people and a variable stiffness actuator press soft specimens.",
        source_script_file_name=f"emg2vsa {__version__}", **more,
    )  # fmt: skip


def _start(began: str, start_s: float) -> tuple[datetime, str]:
    """When the first sample was, by when the file's time 0 was as it states it; and what is to be said of that."""
    try:
        start = datetime.fromisoformat(began.removesuffix(" UTC").strip())
    except ValueError:
        return _UNKNOWN_START, "The file does not state when it began; 1970-01-01 stands for that."
    if start.tzinfo is None:
        told = "" if began.endswith("UTC") else "The file states no time zone; UTC stands for it."
        return start.replace(tzinfo=UTC) + timedelta(seconds=start_s), told
    return start + timedelta(seconds=start_s), ""


def _subject(label: str, person: Person) -> Subject:
    age = f"P{person.age}Y" if person.age.isdecimal() else None
    said = f"handedness: {person.handedness}" if person.handedness else "a person"
    sex = _SEXES.get(person.sex.strip().lower(), "U")
    return Subject(subject_id=label, species="Homo sapiens", sex=sex, age=age, description=said)


def _samples(channel: Channel, start_s: float) -> dict[str, Any]:
    said = f"{channel.name!r} of the file: {channel.conversion}"
    data = H5DataIO(channel.samples, compression="gzip")
    return {"data": data, "rate": channel.fs_hz, "starting_time": channel.start_s - start_s, "description": said}


def _add_presses(file: NWBFile, taken: Taken) -> None:
    if not taken.presses:
        return
    columns = {
        "repetition": "Number of the press within the recording.", "verdict": "ok, doubtful (not used) or rejected.",
        "peak_force": "Largest tared, filtered force of the press, N.", "reason": "Reasons of the verdict.",
    }  # fmt: skip
    for name, said in columns.items():
        file.add_trial_column(name, said)
    for press in taken.presses:
        onset_s = press.onset_s - taken.start_s
        cells = {name: press.cells[name] for name in columns} | {"peak_force": float(str(press.cells["peak_force"]))}
        file.add_trial(start_time=onset_s, stop_time=onset_s + (press.duration_s or 0.0), **cells)


def _add_log(file: NWBFile, log: pd.DataFrame) -> None:
    """Columns of numbers share the times of the turns; the commanded ones are stimulus, the others acquisition."""
    times = log["time_s"].to_numpy(np.float64)
    first: TimeSeries | None = None
    for name in log.columns.drop(["time_s", "phase"]):
        values = log[name].to_numpy(np.float64)
        if not np.isfinite(values).any():
            continue
        commanded = _COMMANDED.match(name) is not None
        series = TimeSeries(
            name=name, data=H5DataIO(values, compression="gzip"), unit=_UNITS.get(name.rpartition("_")[2], "n.a."),
            timestamps=times if first is None else first,
            description=f"{'Commanded' if commanded else 'Measured'} in each turn of the loop: {name} of log.csv.",
        )  # fmt: skip
        (file.add_stimulus if commanded else file.add_acquisition)(series)
        first = first or series
    if len(times) > 1:
        _add_phases(file, times, log["phase"].astype(str).to_numpy(), log["repetition"].to_numpy())


def _add_phases(file: NWBFile, times: Any, phase: Any, repetition: Any) -> None:
    table = TimeIntervals(name="phases", description="Phases of the loop, press after press.")
    table.add_column(name="phase", description="Name of the phase.")
    table.add_column(name="repetition", description="Number of the press.")
    begins = np.flatnonzero(np.r_[True, (phase[1:] != phase[:-1]) | (repetition[1:] != repetition[:-1])])
    stops = np.r_[times[begins[1:]], times[-1] + np.median(np.diff(times))]
    for at, stop_s in zip(begins.tolist(), stops.tolist(), strict=True):
        table.add_interval(start_time=times[at], stop_time=stop_s, phase=phase[at], repetition=int(repetition[at]))
    file.add_time_intervals(table)


def _add_trials(file: NWBFile, folder: Path) -> None:
    path = folder / PRESSES_FILE
    if not path.is_file():
        return
    table = pd.read_csv(path, keep_default_na=False, na_values=[""])
    words = {"verdict", "why", "stopped"}
    columns = [name for name in table.columns if name not in ("begun_s", "turned_s")]
    for name in columns:
        file.add_trial_column(name, f"{name} of presses.csv, which docs/how-to/engineer.md explains.")
    for row in table.to_dict("records"):
        cells = {
            name: ("" if pd.isna(row[name]) else str(row[name])) if name in words else row[name] for name in columns
        }
        file.add_trial(start_time=row["begun_s"], stop_time=row["turned_s"], **cells)


def _frames(name: str, frames: FrameSequence) -> ImageSeries:
    """Frames (T, height, width) in grey levels, read one at a time when they are written."""
    known = np.full(len(frames), np.nan) if frames.readings is None else frames.readings.frame_time_s
    lost = np.isnan(known)
    if lost.all():
        raise DataError(
            frames.name, wanted="the time of each frame", found="none in its force log",
            do="NWB needs times: record frame_time_s in force.csv.",
        )  # fmt: skip
    place = np.arange(known.size)
    times = np.interp(place, place[~lost], known[~lost])
    told = f" Times of {int(lost.sum())} frames lay between their neighbours." if lost.any() else ""
    data = DataChunkIterator(
        data=(np.asarray(frames.source.read(i)) for i in range(len(frames))), maxshape=(None, *frames.shape),
        dtype=np.dtype("uint8"), buffer_size=_FRAMES_AT_ONCE,
    )  # fmt: skip
    said = f"Frames of the tactile camera during {name}, (frame, row, column).{told}"
    return ImageSeries(
        name=name, data=H5DataIO(data, compression="gzip"), unit="grey levels", timestamps=times, description=said
    )


def _write(path: Path, file: NWBFile) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    with NWBHDF5IO(path, "w") as opened:
        opened.write(file)
