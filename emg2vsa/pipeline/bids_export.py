"""Own recordings, whole or not at all: as a BIDS-EMG data set, EMG in uV and force in N at their own rates, presses as
events; or by another writer, such as that of NWB."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from emg2vsa import __version__
from emg2vsa.arrays import bridge_gaps, runs_of
from emg2vsa.bids.dataset import DataSet, write_dataset
from emg2vsa.bids.names import EVENTS, RecordingName, is_label, label_of
from emg2vsa.bids.recording import Channel as StoredChannel
from emg2vsa.bids.recording import Event, Recording, event_columns, of_source
from emg2vsa.bids.recording_files import record_s, short_labels, write_recording
from emg2vsa.bids.tables import Column, described
from emg2vsa.errors import DataError, Emg2vsaError, SettingError
from emg2vsa.extraction import Trials
from emg2vsa.extraction.extract import extract_trials
from emg2vsa.fits import Fits, fit_trials
from emg2vsa.readers.bids_sidecars import side_files
from emg2vsa.readers.roles import RoleChannels, read_roles
from emg2vsa.recordings import Channel
from emg2vsa.run_folders.find import find_runs
from emg2vsa.settings import CocontractionSettings, FitSettings, ReadingSettings
from emg2vsa.study import RecordingEntry, RecordingPart, Study

_EVENT_COLUMNS = event_columns(
    onset="Begin of the loading phase or gap, from the start of the recording.",
    duration="Its length.",
    kind=Column(
        "What the row is of.",
        levels={
            "press": "The loading phase of a press, found in the force by emg2vsa.",
            "gap": "Samples that the source file lacks; interpolated linearly here.",
        },
    ),
    own={
        "repetition": Column("Number of the press within the recording."),
        "verdict": Column(
            "Verdict on the press, as it counts in the study: of emg2vsa, or of a person.",
            levels={"ok": "Used.", "doubtful": "Not used: its slope is expected to be off.", "rejected": "Not used."},
        ),
        "peak_force": Column("Largest tared, filtered force of the press.", "N"),
        "reason": Column("Reasons of the verdict."),
    },
)
_UNFINISHED = ".unfinished"
_README = """\
Recordings of people who pressed soft specimens with one finger, converted by emg2vsa {version}. Each has the surface
EMG of the muscles in microvolts (amplifier gain divided out) and the pressing force in newtons (pressing positive, not
tared), at the rates at which they were recorded. `acq-` names the specimen. The events are the presses as emg2vsa found
them, with its verdicts. `run-` counts the recordings of a specimen in their order, whatever numbers their files bear:
see below. The last data record of a file may be filled up by repeating the last sample;
`RecordingDuration` is the true length.

{sources}
"""


@dataclass(frozen=True)
class About:
    """What no recording states. task : BIDS label. mains_hz : of the mains, None where it is not known.

    electrode_mm : distance of the two electrodes of a pair. more : further keys for every _emg.json.
    """

    task: str = "palpation"
    mains_hz: float | None = None
    electrode_mm: float | None = None
    more: Mapping[str, Any] | None = None


def about(task: str, mains_hz: float | None, electrode_mm: float | None, keys: Path | None) -> About:
    """keys : JSON file with more keys for every _emg.json. mains_hz : Hz. electrode_mm : between electrodes, mm.

    SettingError : a distance or a file that cannot be.
    """
    if electrode_mm is not None and not 0 < electrode_mm < 1000:
        found, do = f"{electrode_mm:g}", "Measure centre to centre."
        raise SettingError("--electrode-distance", wanted="millimetres above 0", found=found, do=do)
    return About(task, mains_hz, electrode_mm, {} if keys is None else _keys(keys))


def _keys(path: Path) -> dict[str, Any]:
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        found = getattr(error, "strerror", None) or str(error)
        raise SettingError(path, wanted="a JSON object", found=found, do="Correct the file.") from error
    if not isinstance(content, dict):
        raise SettingError(path, wanted="a JSON object", found=type(content).__name__, do='Write {"Key": "value"}.')
    return content


@dataclass(frozen=True)
class Taken:
    """A recording as it is to be written. presses : on its own clock. further : keys of _emg.json that are known."""

    name: RecordingName
    entry: RecordingEntry
    part: RecordingPart
    roles: RoleChannels
    presses: Sequence[Event]
    about: About
    further: Mapping[str, Any]

    @property
    def start_s(self) -> float:
        """Start of the channel that begins first, s."""
        return min(channel.start_s for channel in (*self.roles.emg.values(), self.roles.force))


@dataclass(frozen=True)
class Writer:
    """Another format than BIDS. Each writes below a folder, of a run the one given last, and returns what it wrote."""

    recording: Callable[[Path, Taken], list[Path]]
    run: Callable[[Path, Path], Path]


@dataclass(frozen=True)
class Exported:
    """files : written. failures : (recording, message) of those that could not be read. notes : to be said."""

    files: tuple[Path, ...]
    failures: tuple[tuple[str, str], ...]
    notes: tuple[str, ...]


def export(
    folder: Path,
    name: str,
    entries: Sequence[RecordingEntry],
    about: About,
    *,
    base: Path,
    cocontraction: CocontractionSettings,
    reading: ReadingSettings,
    fits: Mapping[str, Fits] | None = None,
    progress: Callable[[int, int, str], None] | None = None,
    writer: Writer | None = None,
    runs: Sequence[Path] = (),
) -> Exported:
    """Write the recordings into ``folder``, which must be empty or absent: whole, or nothing.

    writer : of another format, which takes folders of ``runs`` too; None: as a BIDS data set. base : folder that
    calibration files are relative to. fits : of a study by key of the recording, whose verdicts and reasons the events
    have; None: the recordings belong to no study, and are fitted here by the default settings. What cannot be read is
    left out and reported.
    SettingError : the folder holds files or cannot be written to, or two names become one BIDS label.
    """
    files: list[Path] = []
    failures: list[tuple[str, str]] = []
    notes: list[str] = []
    sources: list[str] = []
    written: set[str] = set()
    total = sum(len(entry.parts) for entry in entries) + len(runs)
    judging = {} if fits is None else {entry.key: _Judged(fits.get(entry.key)) for entry in entries}
    with _whole_or_nothing(folder) as unfinished:
        for entry, part, recording in _named(entries, about.task):
            if progress is not None:
                progress(len(files) + len(failures), total, entry.key)
            try:
                judged = judging.get(entry.key)
                taken, said = _take(recording, entry, part, about, base, cocontraction, reading, judged)
                made = _write(unfinished, taken, said) if writer is None else writer.recording(unfinished, taken)
            except Emg2vsaError as error:
                failures.append((entry.key, str(error)))
                continue
            files += [folder / path.relative_to(unfinished) for path in made]
            written.add(recording.participant)
            notes += [f"{made[0].name}: {note}" for note in said]
            used = ", ".join(path.name for path in (part.emg_file, part.force_file) if path is not None)
            sources += [f"- `{path.name}`: {used}" for path in made]
        for own in runs:
            assert writer is not None
            if progress is not None:
                progress(len(files) + len(failures), total, own.name)
            try:
                files.append(folder / writer.run(unfinished, own).relative_to(unfinished))
            except DataError as error:
                failures.append((own.name, str(error)))
        if files and writer is None:
            listed = "\n".join(["Each file and what it was made from:", "", *sources])
            told = {about.task: described(_EVENT_COLUMNS)} if any(unfinished.rglob(f"*{EVENTS}")) else {}
            whole = DataSet(
                name, "Conversion of recordings to BIDS-EMG.", _README.format(version=__version__, sources=listed),
                participants=sorted(written), events=told,
            )  # fmt: skip
            write_dataset(unfinished, whole)
    return Exported(tuple(files), tuple(failures), tuple(dict.fromkeys(notes)))


def _named(
    entries: Sequence[RecordingEntry], task: str
) -> Iterator[tuple[RecordingEntry, RecordingPart, RecordingName]]:
    """Every file of every entry with its name in BIDS. SettingError : the task is no label, or two names become one."""
    if not is_label(task):
        raise SettingError("--task", wanted="letters and digits only", found=repr(task), do="Rename the task.")
    people = _labels("participant", [entry.participant for entry in entries])
    specimens = _labels("specimen", [entry.specimen for entry in entries if entry.specimen])
    for entry in entries:
        for number, part in enumerate(entry.parts, 1):
            of_visit = [n for n, other in enumerate(entry.parts, 1) if other.visit == part.visit]
            run = of_visit.index(number) + 1 if len(of_visit) > 1 else None
            specimen = specimens[entry.specimen] if entry.specimen else ""
            yield entry, part, RecordingName(people[entry.participant], task, specimen, run, visit=part.visit)


def run_folders(study: Study) -> list[Path]:
    """Folders of the runs of a study that are there."""
    source = study.runs_source
    if source is None or not source.root.is_dir():
        return []
    return [folder for run in find_runs(source.root, study.pressed_n_per_mm) for folder in run.folders]


@contextmanager
def _whole_or_nothing(folder: Path) -> Iterator[Path]:
    """Where to write what comes into ``folder`` when all of it is there. SettingError : as ``export``."""
    unfinished = folder / _UNFINISHED
    if folder.exists() and (not folder.is_dir() or any(path != unfinished for path in folder.iterdir())):
        raise SettingError(
            folder, wanted="an empty or absent folder", found="files in it", do="Choose another folder with --out."
        )
    absent = not folder.exists()
    try:
        shutil.rmtree(unfinished, ignore_errors=True)  # of a conversion that was killed
        unfinished.mkdir(parents=True)
        yield unfinished
        for path in unfinished.iterdir():
            path.rename(folder / path.name)
    except OSError as error:
        raise SettingError(
            folder, wanted="a folder with room for the data set", found=error.strerror or str(error),
            do="Make room, or choose another folder with --out. Nothing was left in it.",
        ) from error  # fmt: skip
    finally:
        shutil.rmtree(unfinished, ignore_errors=True)
        if absent and folder.is_dir() and not any(folder.iterdir()):
            folder.rmdir()


def _labels(what: str, names: Sequence[str]) -> dict[str, str]:
    """Names without what a BIDS label may not hold. SettingError where nothing is left, or two become one."""
    labels = {name: label_of(name) for name in names}
    for name, label in labels.items():
        twins = [other for other, own in labels.items() if own.casefold() == label.casefold()]
        if not label or len(twins) > 1:
            raise SettingError(
                f"{what} {name!r}", wanted="a name of its own in letters and digits, for it becomes a BIDS label",
                found=" and ".join(map(repr, twins)), do="Rename it in the study file.",
            )  # fmt: skip
    return labels


def _take(
    name: RecordingName, entry: RecordingEntry, part: RecordingPart, about: About, base: Path,
    cocontraction: CocontractionSettings, reading: ReadingSettings, judged: _Judged | None,
) -> tuple[Taken, list[str]]:  # fmt: skip
    """One recording, read and with its presses, and what is to be said of it."""
    if part.fault:
        raise SettingError(
            part.emg_file.parent, wanted=f"one file of {entry.key}", found=part.fault,
            do="Name the file in the study file.",
        )  # fmt: skip
    calibration = part.channels.force.cal_file
    roles = read_roles(
        part.emg_file, part.force_file, part.channels, reading, base / calibration if calibration else None
    )
    notes = []
    presses: list[Event] = []
    try:
        trials = extract_trials(
            roles.emg, roles.force, participant=entry.participant, specimen=entry.specimen, filters=entry.filters,
            cocontraction=replace(cocontraction, normalise="none"),  # an event has times and force, and no activity
            window=entry.window, force_channel=part.channels.force,
        )  # fmt: skip
        own = _Judged(fit_trials(trials, FitSettings(), entry.window)) if judged is None else judged
        presses = own.presses(trials)
    except Emg2vsaError as error:
        notes.append(f"no events were written: {error}")
    further = {**of_source(side_files(part.emg_file).emg), **(about.more or {})}
    return Taken(name, entry, part, roles, presses, about, further), notes


def _write(folder: Path, taken: Taken, notes: list[str]) -> list[Path]:
    """Data and side files of a recording; several where its rates share no data record. Adds to ``notes``."""
    for channel in (*taken.roles.emg.values(), taken.roles.force):
        if moved := _moved(channel, taken.start_s):
            notes.append(f"{channel.name}: {moved}")
    paths = []
    for label, channels in _groups(taken.roles).items():
        name = replace(taken.name, part=label)
        recording = _recording(name, channels, taken.part, taken.presses, taken.start_s, taken.about)
        paths.append(write_recording(folder, replace(recording, further=taken.further)))
    return paths


_Named = dict[str, tuple[Channel, str | None]]
"""Label of a channel to it and its muscle, None for the force."""


def _groups(roles: RoleChannels) -> dict[str, _Named]:
    """Channels that can share a file, all in one if possible."""
    names = [*roles.emg, "force" if roles.force.name in roles.emg else roles.force.name]
    channels = [*roles.emg.values(), roles.force]
    named = dict(zip(short_labels(names), zip(channels, (*roles.emg, None), strict=True), strict=True))
    if record_s(channel.fs_hz for channel in channels) is not None:
        return {"": named}
    rates = sorted({channel.fs_hz for channel in channels}, reverse=True)
    return {
        f"rate{number}": {label: pair for label, pair in named.items() if pair[0].fs_hz == rate}
        for number, rate in enumerate(rates, 1)
    }


def _recording(
    name: RecordingName, channels: _Named, part: RecordingPart, presses: Sequence[Event], start_s: float, about: About
) -> Recording:
    """What one data file holds."""
    own = [channel for channel, _ in channels.values()]
    length_s = record_s(channel.fs_hz for channel in own)
    if length_s is None:
        raise SettingError(
            part.emg_file, wanted="a sampling rate that BDF can hold to a millionth",
            found=f"{min(channel.fs_hz for channel in own):.9g} Hz", do="Resample the recording.",
        )  # fmt: skip
    earlier = [round((channel.start_s - start_s) * channel.fs_hz) for channel in own]
    counts = [round(channel.fs_hz * length_s) for channel in own]
    sizes = [channel.samples.size for channel in own]
    records = max(-(-(before + n) // count) for before, n, count in zip(earlier, sizes, counts, strict=True))
    stop_s = max(channel.start_s + channel.duration_s for channel in own)
    stored, gaps = [], []
    for (label, (channel, muscle)), before, count in zip(channels.items(), earlier, counts, strict=True):
        samples, missing = bridge_gaps(channel.samples, f"channel {channel.name!r}")
        filled = np.pad(samples, (before, records * count - before - samples.size), mode="edge")
        scale, unit = (1e6, "uV") if muscle else (1.0, "N")
        stored_hz = count / length_s
        repeated = f"the first {before} samples repeat the first one recorded" if before else ""
        told = "; ".join(filter(None, (repeated, _moved(channel, start_s))))
        said = f"; in the source {channel.name!r}: {channel.conversion}"
        stored.append(StoredChannel(label, filled * scale, unit, stored_hz, muscle, said, told))
        first, stop = runs_of(missing)
        lost = zip(first.tolist(), stop.tolist(), strict=True)
        gaps += [Event(round((before + i) / stored_hz, 6), round((j - i) / stored_hz, 6), "gap") for i, j in lost]
    events = [replace(press, onset_s=round(press.onset_s - start_s, 4)) for press in presses]
    fs_hz = next((channel.fs_hz for channel, muscle in channels.values() if muscle), own[0].fs_hz)
    return Recording(
        name, stored, fs_hz, stop_s - start_s, length_s, equipment="emg2vsa-convert",
        software=f"converted by emg2vsa {__version__}",
        events=sorted(gaps + events, key=lambda event: event.onset_s) or None, columns=_EVENT_COLUMNS,
        mains_hz=about.mains_hz, electrode_mm=about.electrode_mm,
    )  # fmt: skip


def _moved(channel: Channel, start_s: float) -> str:
    """Note on how far a channel is from its time, as all channels of a file start with a sample; "" below a
    microsecond.
    """
    offset_s = (channel.start_s - start_s) * channel.fs_hz
    moved_s = (round(offset_s) - offset_s) / channel.fs_hz
    return f"moved by {1e3 * moved_s:+.3g} ms, to its nearest sample" if abs(moved_s) > 1e-6 else ""


@dataclass
class _Judged:
    """The verdicts of all presses of one participant on one specimen, whose files are gone through in turn."""

    fits: Fits | None
    _next: int = 0

    def presses(self, trials: Trials) -> list[Event]:
        """The presses of the next file, on its own clock.

        The fits number those of all files on, and add whole seconds to their times.
        """
        n = trials.repetition.size
        if n == 0:
            return []
        starts_s = np.empty(0) if self.fits is None else self.fits.start_s
        for first in range(self._next, starts_s.size - n + 1):
            added_s = starts_s[first : first + n] - trials.start_s
            if np.allclose(added_s, np.rint(added_s[0]), rtol=0, atol=1e-6):
                break
        else:
            raise SettingError(
                f"{trials.participant}/{trials.specimen}", wanted="its presses among those of the study",
                found="none of them", do="Ask emg2vsa check why the recording is not used.",
            )  # fmt: skip
        self._next = first + n
        assert self.fits is not None
        judged = slice(first, self._next)
        verdicts, reasons = self.fits.verdict[judged].tolist(), self.fits.reason[judged].tolist()
        own = (trials.start_s, trials.duration_s, trials.repetition, trials.peak_force_n)
        rows = zip(*(column.tolist() for column in own), verdicts, reasons, strict=True)
        return [
            Event(
                start_s, round(duration_s, 4), "press",
                {"repetition": n, "verdict": verdict, "peak_force": f"{peak_n:.4g}", "reason": reason or "n/a"},
            )
            for start_s, duration_s, n, peak_n, verdict, reason in rows
        ]  # fmt: skip
