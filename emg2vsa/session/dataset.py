"""The folder of a session as BIDS-EMG: one recording for each stay at a specimen, and what happened in it as events.

Made from the folder alone, which it does not change but for a list of the files that it wrote: written again from the
same folder, every file has the same bytes. A file of the data set that it did not write is never replaced.
"""

from __future__ import annotations

import json
import os
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta
from pathlib import Path

from casr.atomic import write_text_atomic
from emg2vsa import __version__
from emg2vsa.arrays import bridge_gaps
from emg2vsa.bids import dataset as bids
from emg2vsa.bids.electrodes import Electrodes, write_electrodes
from emg2vsa.bids.names import RecordingName, remove_recording
from emg2vsa.bids.recording import Channel, Recording, told_of_screen
from emg2vsa.bids.recording_files import write_recording
from emg2vsa.bids.tables import Json
from emg2vsa.durable.system import PRIVATE
from emg2vsa.errors import DataError, Emg2vsaError, SettingError
from emg2vsa.session.dataset_events import EVENT_COLUMNS, stay_events
from emg2vsa.session.journal import (
    JOURNAL_FILE,
    Begun,
    Line,
    Noted,
    gaps,
    read_journal,
)
from emg2vsa.session.plan import PLAN_FILE, Plan, read_plan
from emg2vsa.session.presses import Presses, folded
from emg2vsa.session.stays import StaySignals, StayWindow, StoredStream, cut, stay_windows, stored_streams
from emg2vsa.session.views import ScreenReport
from emg2vsa.session_settings import SessionAbout, SessionSettings
from emg2vsa.settings import ChannelSettings
from emg2vsa.study import Study

TRAINING_TASK = "training"
WRITTEN_FILE = "written.json"
_README = """\
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
            study.path, wanted="a table [session]", found="none",
            do="Put the table back with which the session was run.",
        )  # fmt: skip
    plan = read_plan(folder / PLAN_FILE)
    lines, _ = read_journal(folder / JOURNAL_FILE)
    presses = folded(lines, plan.presses)
    streams, faults = stored_streams(folder, lines)
    windows = stay_windows(presses)
    stays, left_out = _stays(study, plan, lines, streams, windows)
    targets = [stay.name.path(study.data) for stay in stays]
    title = study.title or study.name
    whole = bids.DataSet(
        title, "Sessions of participants, run and recorded.", _README.format(version=__version__),
        participants=(plan.participant,), participant="Code of the participant.", ethics=settings.ethics,
        authors=settings.about.authors, licence=settings.about.licence,
    )  # fmt: skip
    try:
        _make_room(folder, study.data, targets)
        for stay in stays:
            write_recording(study.data, stay.recording(settings, presses, plan))
        bids.write_dataset(study.data, whole, keep=True)
        if stays:
            write_electrodes(study.data, plan.participant, plan.visit, _electrodes(stays[0].channels, settings))
        began = {stay.name: stay.begun().isoformat(timespec="milliseconds") for stay in stays}
        bids.write_scans(study.data, plan.participant, began, keep=True, visit=plan.visit)
    except OSError as error:
        raise SettingError(
            study.data, wanted="a data set with room for the session", found=error.strerror or str(error),
            do="Make room and write it again: emg2vsa session finish. The session itself is whole.",
        ) from error  # fmt: skip
    return Written(tuple(targets), tuple(left_out), (*map(str, faults), *_notes(lines, windows, stays)))


def _stays(
    study: Study, plan: Plan, lines: Sequence[Line], streams: Mapping[tuple[int, str], list[StoredStream]],
    windows: Sequence[StayWindow],
) -> tuple[list[_Stay], list[tuple[str, str]]]:  # fmt: skip
    """The stays at specimens that can be written; and those that cannot, with the reason."""
    assert study.session is not None
    stays: list[_Stay] = []
    left_out: list[tuple[str, str]] = []
    for name, window in zip(_names(windows, plan, study.task), windows, strict=True):
        emg, force = (streams.get((window.sitting, kind), []) for kind in ("emg", "force"))
        own = [line for line in lines if line.sitting == window.sitting]
        try:
            channels, signals = _channels(study, plan.participant, window.specimen), cut(window, emg, force)
            stored = _stored(signals, channels, name.stem, study.session.about)
            stays.append(_Stay(name, window, own, signals, stored))
        except Emg2vsaError as error:
            left_out.append((f"{window.phase} on {window.specimen}", str(error)))
    return stays, left_out


def refuse_foreign(folder: Path, study: Study, participant: str) -> None:
    """DataError where recordings of the participant are in the data set that the session in ``folder`` did not write.

    Asked before the first press, so that nobody is measured in vain.
    """
    own = _known(folder)
    for entry in study.recordings:
        own_parts = (part for part in entry.parts if (entry.participant, part.visit) == (participant, study.visit))
        for path in (part.emg_file for part in own_parts):
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


def _names(windows: Sequence[StayWindow], plan: Plan, task: str) -> list[RecordingName]:
    """Names of the recordings; several of one specimen are numbered."""
    keys = [(window.phase, window.specimen) for window in windows]
    names = []
    for i, (phase, specimen) in enumerate(keys):
        run = keys[: i + 1].count(keys[i]) if keys.count(keys[i]) > 1 else None
        of_phase = TRAINING_TASK if phase == "training" else task
        names.append(RecordingName(plan.participant, of_phase, specimen, run, visit=plan.visit))
    return names


def _stored(signals: StaySignals, channels: ChannelSettings, stem: str, about: SessionAbout) -> list[Channel]:
    """SignalError where all of a channel is lost. DataError where a muscle of the study was not recorded."""
    stored = []
    for muscle, channel in channels.emg.items():
        if muscle not in signals.muscles:
            raise DataError(
                stem, wanted=f"the muscle {muscle} of [channels.emg]", found=", ".join(signals.muscles),
                do="Put the table back with which the session was run.",
            )  # fmt: skip
        emg_v, _ = bridge_gaps(signals.emg_v[:, signals.muscles.index(muscle)], f"{stem}, {muscle}")
        said = f"; {_measured(signals, 0)}"
        band = _band_hz(signals, muscle, about)
        stored.append(Channel(channel.name, emg_v * 1e6, "uV", signals.emg_fs_hz, muscle, said, band_hz=band))
    force_n, _ = bridge_gaps(signals.force_n, f"{stem}, force")
    name, sign = channels.force.name, channels.force.sign
    said = f", {'pressing positive' if sign > 0 else 'pressing negative'}; {_measured(signals, 1)}"
    told = f"the first sample is {1e3 * signals.offset_s:+.3f} ms from the first one of the EMG"
    return [*stored, Channel(name, force_n * sign, "N", signals.force_fs_hz, None, said, told)]


def _make_room(folder: Path, root: Path, targets: Sequence[Path]) -> None:
    """Remove what an earlier call wrote and this one will not. DataError where a target is not its own.

    The list of what will be written comes first, so that what a killed call left is known as its own.
    """
    known, before = folder / WRITTEN_FILE, _known(folder)
    new = [target.relative_to(root).as_posix() for target in targets]
    for name in new:
        if name not in before and (root / name).exists():
            raise _foreign(root / name)
    write_text_atomic(known, json.dumps(sorted({*before, *new}), indent=2) + "\n", mode=PRIVATE)
    for name in before:
        if name not in new:
            remove_recording(root / name)
    write_text_atomic(known, json.dumps(sorted(new), indent=2) + "\n", mode=PRIVATE)


@dataclass(frozen=True)
class _Stay:
    """What becomes one recording. lines : of its sitting."""

    name: RecordingName
    window: StayWindow
    lines: Sequence[Line]
    signals: StaySignals
    channels: Sequence[Channel]

    def begun(self) -> datetime:
        """Date and time of day, without its zone, of the first sample."""
        line = self.lines[0]
        since_s = self.signals.start_s - line.time_s
        return datetime.fromisoformat(line.at).replace(tzinfo=None) + timedelta(seconds=since_s)

    def recording(self, settings: SessionSettings, presses: Presses, plan: Plan) -> Recording:
        signals, about = self.signals, settings.about
        stated = {
            "instructions": about.instructions, "skin_preparation": about.skin_preparation, "ground": about.ground,
            "electrodes": about.electrodes, "electrode_manufacturer": about.electrode_manufacturer,
            "electrode_type": about.electrode_type, "electrode_material": about.electrode_material,
            "institution": about.institution, "institution_address": about.institution_address,
            "institutional_department_name": about.department, "manufacturer": about.manufacturer,
            "model": about.model, "serial": about.serial_number,
        }  # fmt: skip
        filters = {"hardware_filters": _filters(self.channels)}
        how = {**_device(signals), **filters, **{term: told for term, told in stated.items() if told}}
        return Recording(
            self.name, self.channels, signals.emg_fs_hz, signals.duration_s,
            signals.record_s, equipment="emg2vsa-session", software=f"emg2vsa {__version__}",
            events=stay_events(self.window, signals, self.lines, presses), columns=EVENT_COLUMNS, decimals=6,
            screen=_screen(self.lines), started=self.begun().replace(microsecond=0), mains_hz=about.power_line_hz,
            electrode_mm=about.electrode_mm, how=how,
            further={"SpecimenOrder": _order(plan)},
        )  # fmt: skip


def _order(plan: Plan) -> Json:
    """Order of the specimens in the session, and its rule."""
    pressed = dict.fromkeys(press.specimen for press in plan.presses if press.phase == "main")
    kind = {"kind": plan.settings.get("session", {}).get("order", "n/a")}  # earlier plans tell no more
    return {key.capitalize(): told for key, told in {**kind, **plan.order, "specimens": list(pressed)}.items()}


def _electrodes(channels: Sequence[Channel], settings: SessionSettings) -> Electrodes:
    """Electrodes of all muscles, as electrodes.tsv has them."""
    places, about = settings.places, settings.about
    pairs = {channel.pair_name: channel.muscle for channel in channels if channel.muscle}
    known = {name: places.pairs[muscle] for name, muscle in pairs.items()} if places else dict.fromkeys(pairs)
    return Electrodes(
        known, places.system if places else "", places.unit if places else "n/a",
        about.electrode_type, about.electrode_material,
    )  # fmt: skip


def _measured(signals: StaySignals, which: int) -> str:
    """What is known of the clock of a stream, for its description."""
    stated = (signals.emg, signals.force)[which].fs_hz
    se_s = signals.clock_se_s[which]
    known = f", a sample's time to {1e3 * se_s:.2g} ms" if se_s == se_s else ""
    lost = f"; {signals.lost[which]} samples lost" if signals.lost[which] else ""
    return f"stated {stated:.9g} Hz, by the computer's clock {signals.measured_hz[which]:.9g} Hz{known}{lost}"


def _device(signals: StaySignals) -> dict[str, str]:
    """What the devices say of themselves."""
    facts = {**{f"Force {name}": fact for name, fact in signals.force.facts.items()}, **signals.emg.facts}
    return {"manufacturer": "n/a", **dict(sorted(facts.items())), "software_filters": "n/a"}


def _band_hz(signals: StaySignals, muscle: str, about: SessionAbout) -> tuple[float, float] | None:
    """Band of the amplifier's own filters, Hz, as the study file or the device says."""
    told = re.fullmatch(r"([0-9.]+) to ([0-9.]+) Hz", signals.emg.facts.get(f"{muscle}, band", ""))
    return about.band_hz or ((float(told[1]), float(told[2])) if told else None)


def _filters(channels: Sequence[Channel]) -> Json | str:
    """HardwareFilters of the muscles' channels."""
    known = {channel.label: channel.band_hz for channel in channels if channel.muscle and channel.band_hz}
    parts = ("High-pass cut-off (Hz)", "Low-pass cut-off (Hz)")
    return {f"Band of {name}": dict(zip(parts, band, strict=True)) for name, band in known.items()} or "n/a"


def _screen(lines: Sequence[Line]) -> Json:
    begun = next((event for line in lines if isinstance(event := line.event, Begun)), None)
    told = next((event for line in lines if isinstance(event := line.event, ScreenReport)), None)
    terms: Json = {"operating_system": begun.computer} if begun else {}
    if told and {"width", "height"} <= told.more.keys():
        terms["screen_resolution"] = [told.more["width"], told.more["height"]]
    return told_of_screen(software_version=begun.software if begun else __version__, **terms)


def _notes(lines: Sequence[Line], windows: Sequence[StayWindow], stays: Sequence[_Stay]) -> Iterable[str]:
    yield from gaps(lines)
    if not windows:
        yield "No complete press was recorded, so there is no recording to write."
    if any(isinstance(line.event, Noted) for line in lines):
        yield "The operator's notes are in the events files. See that no note names a person."
    for stay in stays:
        for name, lost in zip(("EMG", "force"), stay.signals.lost, strict=True):
            if lost:
                lost_in = f"{stay.name.stem}: {lost} samples of the {name}"
                yield f"{lost_in} are lost; they are interpolated, and marked as gaps."
