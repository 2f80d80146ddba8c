"""The folder of a session as BIDS-EMG: one recording for each stay at a specimen, and what happened in it as events.

Made from the folder alone, which it does not change but for a list of the files that it wrote: written again from the
same folder, every file has the same bytes. A file of the data set that it did not write is never replaced.
"""

from __future__ import annotations

import csv
import json
import os
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta
from pathlib import Path

from casr.atomic import write_bytes_atomic, write_text_atomic
from emg2vsa import __version__
from emg2vsa.arrays import bridge_gaps
from emg2vsa.bids import (
    CHANNEL_COLUMNS,
    BdfChannel,
    Json,
    bdf_bytes,
    channel_cells,
    description,
    emg_sidecar,
    write_json,
    write_tsv,
)
from emg2vsa.errors import DataError, Emg2vsaError, SettingError
from emg2vsa.session.dataset_events import (
    EVENT_COLUMNS,
    EVENTS_JSON,
    event_rows,
    press_attempts,
)
from emg2vsa.session.journal import (
    JOURNAL_FILE,
    Begun,
    Line,
    Noted,
    ScreenTold,
    gaps,
    read_journal,
)
from emg2vsa.session.plan import PLAN_FILE, read_plan
from emg2vsa.session.stays import StaySignals, StayWindow, cut, in_sitting, stay_windows, stored_streams
from emg2vsa.session_settings import SessionSettings
from emg2vsa.settings import ChannelSettings
from emg2vsa.study import Study

TRAINING_TASK = "training"
WRITTEN_FILE = "written.json"
_README = """\
# {name}

Sessions run by emg2vsa {version}: people press soft specimens with one finger while the surface EMG of forearm muscles
and the pressing force are recorded. One recording for each stay at a specimen; `acq-` names it, `run-` counts the stays
at one specimen where there are several, `task-training` is practice. The clock of a recording is that of its EMG; the
force is stored at the rate that it has by this clock. `events.tsv` has the commands, the presses with verdict and
decision, pauses and notes. `sourcedata` has what was recorded, sample by sample, and every event; it is never changed.
"""


@dataclass(frozen=True)
class Written:
    """files : recordings in the data set. left_out : (stay, why) of those that could not be written. notes : to say."""

    files: tuple[Path, ...]
    left_out: tuple[tuple[str, str], ...] = ()
    notes: tuple[str, ...] = ()


def write_dataset(folder: Path, study: Study) -> Written:
    """The session in ``folder`` into the data set of ``study``, whose recordings it becomes.

    Recordings of an earlier call are replaced. DataError : plan or journal are damaged, or a recording is in the data
    set already that no session wrote. SettingError : the data set cannot be written to.
    """
    settings = study.session
    if settings is None:
        raise SettingError(
            study.path,
            wanted="a table [session]",
            found="none",
            do="Put the table back with which the session was run.",
        )
    plan = read_plan(folder / PLAN_FILE)
    lines, _ = read_journal(folder / JOURNAL_FILE)
    presses = press_attempts(lines, plan.presses)
    streams, faults = stored_streams(folder, lines)
    windows = stay_windows(lines)
    stems = _stems(windows, plan.participant, study.task)
    left_out: list[tuple[str, str]] = []
    signals: dict[str, StaySignals] = {}
    for stem, window in zip(stems, windows, strict=True):
        try:
            emg, force = (streams.get((window.sitting, name), []) for name in ("emg", "force"))
            signals[stem] = _usable(cut(window, emg, force), _channels(study, plan.participant, window.specimen), stem)
        except Emg2vsaError as error:
            left_out.append((f"{window.phase} on {window.specimen}", str(error)))
    subject = study.data / f"sub-{plan.participant}"
    targets = [subject / "emg" / f"{stem}_emg.bdf" for stem in signals]
    try:
        _make_room(folder, study.data, targets)
        scans = []
        for (stem, own), target in zip(signals.items(), targets, strict=True):
            window = windows[stems.index(stem)]
            rows = event_rows(window, own, list(in_sitting(lines, window.sitting)), presses)
            channels = _channels(study, plan.participant, window.specimen)
            _write_recording(target, window, own, rows, channels, settings, study, lines)
            scans.append((target.relative_to(subject).as_posix(), _at(lines, window.sitting, own.start_s)))
        _write_tables(study, plan.participant, scans, settings)
    except OSError as error:
        raise SettingError(
            study.data, wanted="a data set with room for the session", found=error.strerror or str(error),
            do="Make room and write it again: emg2vsa session finish. The session itself is whole.",
        ) from error  # fmt: skip
    return Written(tuple(targets), tuple(left_out), (*map(str, faults), *_notes(lines, signals)))


def refuse_foreign(folder: Path, study: Study, participant: str) -> None:
    """DataError where recordings of the participant are in the data set that the session in ``folder`` did not write.

    Asked before the first press, so that nobody is measured in vain.
    """
    own = _known(folder)
    for entry in study.recordings:
        for path in entry.files if entry.participant == participant else ():
            if path.exists() and Path(os.path.relpath(path, study.data)).as_posix() not in own:
                raise _foreign(path)


def _known(folder: Path) -> list[str]:
    """Files that the session wrote into the data set, relative to its root."""
    path = folder / WRITTEN_FILE
    if not path.exists():
        return []
    try:
        names = json.loads(path.read_text(encoding="utf-8"))
        if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
            raise ValueError("no list of names")
    except (OSError, ValueError) as error:
        raise DataError(
            path, wanted="the list of recordings that the session wrote", found=str(error),
            do="Move the participant's recordings and this file away, and write them again: emg2vsa session finish.",
        ) from error  # fmt: skip
    return names


def _foreign(path: Path) -> DataError:
    return DataError(
        path, wanted="no recording of that name in the data set", found="one that this session did not write",
        do="Move it away, or run the session with another participant's code.",
    )  # fmt: skip


def _channels(study: Study, participant: str, specimen: str) -> ChannelSettings:
    """The channels by which the recording is read; practice has those of another specimen."""
    own = {entry.specimen: entry.channels for entry in study.recordings if entry.participant == participant}
    if not own:
        raise SettingError(
            f"participant {participant}", wanted=f"a participant of {study.path}", found="another code",
            do="Put the code back into [participants].",
        )  # fmt: skip
    return own.get(specimen, next(iter(own.values())))


def _stems(windows: Sequence[StayWindow], participant: str, task: str) -> list[str]:
    """Names of the recordings; several of one specimen are numbered."""
    keys = [(window.phase, window.specimen) for window in windows]
    stems = []
    for i, (phase, specimen) in enumerate(keys):
        run = f"_run-{keys[: i + 1].count(keys[i])}" if keys.count(keys[i]) > 1 else ""
        label = TRAINING_TASK if phase == "training" else task
        stems.append(f"sub-{participant}_task-{label}_acq-{specimen}{run}")
    return stems


def _usable(signals: StaySignals, channels: ChannelSettings, stem: str) -> StaySignals:
    """SignalError where more than half of a channel is lost. DataError where a muscle of the study was not recorded."""
    for muscle in channels.emg:
        if muscle not in signals.muscles:
            raise DataError(
                stem, wanted=f"the muscle {muscle} of [channels.emg]", found=", ".join(signals.muscles),
                do="Put the table back with which the session was run.",
            )  # fmt: skip
        bridge_gaps(signals.emg_v[:, signals.muscles.index(muscle)], f"{stem}, {muscle}")
    bridge_gaps(signals.force_n, f"{stem}, force")
    return signals


def _make_room(folder: Path, root: Path, targets: Sequence[Path]) -> None:
    """Remove what an earlier call wrote and this one will not. DataError where a target is not its own.

    The list of what will be written comes first, so that what a killed call left is known as its own.
    """
    known, before = folder / WRITTEN_FILE, _known(folder)
    new = [target.relative_to(root).as_posix() for target in targets]
    for name in new:
        if name not in before and (root / name).exists():
            raise _foreign(root / name)
    write_text_atomic(known, json.dumps(sorted({*before, *new}), indent=2) + "\n")
    for name in before:
        if name not in new:
            for ending in ("_emg.bdf", "_emg.json", "_channels.tsv", "_events.tsv", "_events.json"):
                (root / f"{name.removesuffix('_emg.bdf')}{ending}").unlink(missing_ok=True)
    write_text_atomic(known, json.dumps(sorted(new), indent=2) + "\n")


def _write_recording(
    target: Path, window: StayWindow, signals: StaySignals, rows: Sequence[Mapping[str, object]],
    channels: ChannelSettings, settings: SessionSettings, study: Study, lines: Sequence[Line],
) -> None:  # fmt: skip
    """Data file and side files of one stay."""
    stem = target.name.removesuffix("_emg.bdf")
    stored: list[BdfChannel] = []
    cells = []
    about = settings.about
    for muscle, channel in channels.emg.items():
        label = channel.name
        samples, _ = bridge_gaps(signals.emg_v[:, signals.muscles.index(muscle)], label)
        stored.append(BdfChannel(label, samples * 1e6, "uV", signals.emg_fs_hz, "bipolar surface electrode"))
        said = f"surface EMG of {muscle}; {_measured(signals, 0)}"
        cells.append(channel_cells(label, muscle, "uV", said, signals.emg_fs_hz, electrode_mm=about.electrode_mm))
    force_n, _ = bridge_gaps(signals.force_n, "force")
    label, sign = channels.force.name, channels.force.sign
    stored.append(BdfChannel(label, force_n * sign, "N", signals.force_fs_hz, "force sensor"))
    said = f"pressing force, {'pressing positive' if sign > 0 else 'pressing negative'}; {_measured(signals, 1)}"
    told = f"the first sample is {1e3 * signals.offset_s:+.3f} ms from the first one of the EMG"
    cells.append(channel_cells(label, None, "N", said, signals.force_fs_hz, electrode_mm=None, told=told))
    annotations = [(float(str(row["onset"])), _number(row["duration"]), str(row["trial_type"])) for row in rows]
    content = bdf_bytes(
        stored, annotations, patient=target.name.split("_")[0].removeprefix("sub-"), equipment="emg2vsa-session",
        record_s=signals.record_s, started=_wall(lines, window.sitting, signals.start_s).replace(microsecond=0),
    )  # fmt: skip
    task = TRAINING_TASK if window.phase == "training" else study.task
    own = emg_sidecar(
        task, tuple(channels.emg), 1, signals.emg_fs_hz, signals.duration_s, mains_hz=about.power_line_hz,
        electrode_mm=about.electrode_mm, software=f"emg2vsa {__version__}",
    )  # fmt: skip
    more = {
        "Instructions": about.instructions, "SkinPreparation": about.skin_preparation, "EMGGround": about.ground,
        "ElectrodeManufacturersModelName": about.electrodes, "InstitutionName": about.institution,
        **_device(signals),
    }  # fmt: skip
    write_json(target.with_name(f"{stem}_emg.json"), own | {key: text for key, text in more.items() if text})
    write_tsv(target.with_name(f"{stem}_channels.tsv"), CHANNEL_COLUMNS, cells)
    write_tsv(
        target.with_name(f"{stem}_events.tsv"), EVENT_COLUMNS, [[row[key] for key in EVENT_COLUMNS] for row in rows]
    )
    write_json(target.with_name(f"{stem}_events.json"), {**EVENTS_JSON, "StimulusPresentation": _screen(lines, window)})
    write_bytes_atomic(target, content)  # last: who waits for the recording finds what belongs to it


def _measured(signals: StaySignals, which: int) -> str:
    """What is known of the clock of a stream, for its description."""
    stated = (signals.emg, signals.force)[which].fs_hz
    se_s = signals.clock_se_s[which]
    known = f", a sample's time to {1e3 * se_s:.2g} ms" if se_s == se_s else ""
    lost = f"; {signals.lost[which]} samples lost" if signals.lost[which] else ""
    return f"stated {stated:.9g} Hz, by the computer's clock {signals.measured_hz[which]:.9g} Hz{known}{lost}"


def _device(signals: StaySignals) -> Json:
    """What the devices say of themselves."""
    facts = {**{f"Force{_camel(k)}": v for k, v in signals.force.facts.items()}, **signals.emg.facts}
    named = {"manufacturer": "Manufacturer", "model": "ManufacturersModelName", "serial": "DeviceSerialNumber"}
    return {
        "Manufacturer": "n/a", **{named.get(key, _camel(key)): value for key, value in sorted(facts.items())},
        "SoftwareFilters": "n/a",
    }  # fmt: skip


def _camel(text: str) -> str:
    return "".join(part[:1].upper() + part[1:] for part in re.split(r"[^A-Za-z0-9]+", text))


def _screen(lines: Sequence[Line], window: StayWindow) -> Json:
    own = list(in_sitting(lines, window.sitting))
    begun = next((event for line in own if isinstance(event := line.event, Begun)), None)
    told = next((event for line in own if isinstance(event := line.event, ScreenTold)), None)
    made: Json = {"SoftwareName": "emg2vsa", "SoftwareVersion": begun.software if begun else __version__}
    if begun:
        made["OperatingSystem"] = begun.computer
    if told and {"width", "height"} <= told.more.keys():
        made["ScreenResolution"] = [told.more["width"], told.more["height"]]
    return made


def _number(cell: object) -> float | None:
    return None if cell == "n/a" else float(str(cell))


def _wall(lines: Sequence[Line], sitting: int, time_s: float) -> datetime:
    """Date and time of day, without its zone, of a time on the clock of a sitting."""
    line = next(in_sitting(lines, sitting))
    return datetime.fromisoformat(line.at).replace(tzinfo=None) + timedelta(seconds=time_s - line.time_s)


def _at(lines: Sequence[Line], sitting: int, time_s: float) -> str:
    return _wall(lines, sitting, time_s).isoformat(timespec="milliseconds")


def _write_tables(study: Study, participant: str, scans: Sequence[tuple[str, str]], settings: SessionSettings) -> None:
    """Tables of the data set as a whole, and the list of the participant's scans; what others wrote stays."""
    root = study.data
    if not (root / "dataset_description.json").exists():
        about = description(study.title or study.name, "raw", "Sessions of participants, run and recorded.")
        ethics = {"EthicsApprovals": [settings.ethics]} if settings.ethics else {}
        write_json(root / "dataset_description.json", about | ethics)
    if not any((root / name).exists() for name in ("README", "README.md", "README.rst", "README.txt")):
        write_text_atomic(root / "README.md", _README.format(name=study.title or study.name, version=__version__))
    if not (root / "participants.json").exists():
        write_json(root / "participants.json", {"participant_id": {"Description": "Code of the participant."}})
    name = f"sub-{participant}"
    _merge(root / "participants.tsv", ("participant_id",), {name: (name,)})
    own = dict(sorted(((file, (file, at)) for file, at in scans), key=lambda row: row[1][1]))
    path = root / name / f"{name}_scans.tsv"
    _merge(path, ("filename", "acq_time"), own, gone=lambda file: not (path.parent / file).exists())


def _merge(
    path: Path,
    columns: Sequence[str],
    new: Mapping[str, Sequence[str]],
    gone: Callable[[str], bool] = lambda key: False,
) -> None:
    """A table with ``new`` rows by their first cell; what else rows have stays, and ``gone`` ones go."""
    rows: list[list[str]] = []
    if path.exists():
        try:
            with path.open(encoding="utf-8-sig", newline="") as lines:
                rows = [row for row in csv.reader(lines, delimiter="\t") if row]
        except (ValueError, csv.Error) as error:
            raise DataError(
                path, wanted="a tab-separated table in UTF-8", found=str(error), do="Correct the file, or move it away."
            ) from error
    head = rows[0] if rows else list(columns)
    if head[0] != columns[0] or not set(columns) <= set(head):
        raise DataError(
            path, wanted=f"columns {', '.join(columns)}, the first of them first", found=", ".join(head),
            do="Correct the table, or move it away.",
        )  # fmt: skip
    kept = {row[0]: row for row in rows[1:] if not gone(row[0])}
    for key, cells in new.items():
        given = dict(zip(columns, cells, strict=True))
        before = dict(zip(head, kept.get(key, []), strict=False))
        kept[key] = [given.get(column, before.get(column, "n/a")) for column in head]
    write_tsv(path, head, list(kept.values()))


def _notes(lines: Sequence[Line], signals: Mapping[str, StaySignals]) -> Iterable[str]:
    yield from gaps(lines)
    if not stay_windows(lines):
        yield "No complete press was recorded, so there is no recording to write."
    if any(isinstance(line.event, Noted) for line in lines):
        yield "The operator's notes are in the events files. See that no note names a person."
    for stem, own in signals.items():
        for name, lost in zip(("EMG", "force"), own.lost, strict=True):
            if lost:
                yield f"{stem}: {lost} samples of the {name} are lost; they are interpolated, and marked as gaps."
