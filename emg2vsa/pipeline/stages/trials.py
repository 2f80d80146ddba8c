"""Trials: read one recording, condition it, find its presses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from emg2vsa.errors import Emg2vsaError, PassingError, RecordingError
from emg2vsa.pipeline.stage import Given, Stage
from emg2vsa.readers.bids_sidecars import equipment, events_beside, session_events, side_file_paths
from emg2vsa.readers.sample_files import same_samples, sample_file_paths

if TYPE_CHECKING:
    from emg2vsa.extraction import Trials
    from emg2vsa.pipeline.campaign import Campaign
    from emg2vsa.settings import ChannelSettings, CocontractionSettings, FilterSettings, ReadingSettings, WindowSettings

LOUD = "NYQUIST RULE"
"""Notes that begin so are said on screen, not only recorded: the study asked for a filter that cannot be built."""
NOT_USED = "recording not used: "
"""Begins the remark on each of several recordings that could not be used; said on screen too."""


def settings(campaign: Campaign, item: str) -> dict[str, Any]:
    entry = campaign.recordings[item]
    return {
        "channels": entry.channels,
        "muscles": tuple(tuple(part.channels.emg) for part in entry.parts),  # a mapping's key has no order
        "filters": entry.filters,
        "window": entry.window,
        "cocontraction": campaign.study.cocontraction,
        "reading": campaign.study.reading,
        "fault": entry.fault,
        "further": tuple((part.channels, part.fault) for part in entry.further),
        "visits": tuple(part.visit for part in entry.parts),
    }


def files(campaign: Campaign, item: str) -> dict[str, Sequence[str | Path]]:
    found: dict[str, Sequence[str | Path]] = {}
    mvc = campaign.recordings[item].mvc_files
    sides: list[str | Path] = [side for path in mvc for side in _beside(campaign, path)]
    for number, part in enumerate(campaign.recordings[item].parts, 1):
        own = (part.emg_file, part.force_file) if part.force_file else (part.emg_file,)
        sides += [side for path in own for side in _beside(campaign, path)]
        sides += events_beside(part.emg_file, campaign.side_files)
        calibration = part.channels.force.cal_file
        found |= {
            _role("emg", number): own[:1],
            _role("force", number): own[1:],
            _role("calibration", number): (campaign.study.path.parent / calibration,) if calibration else (),
        }
    return {**found, "mvc": mvc, "beside": sides}


def _beside(campaign: Campaign, path: Path) -> tuple[str | Path, ...]:
    return (*side_file_paths(path, campaign.side_files), *sample_file_paths(path))


def _role(name: str, number: int) -> str:
    return name if number == 1 else f"{name} {number}"


def run(given: Given) -> Trials:
    """The presses of one recording, or of all of the item's; one that cannot be used is left out of several.

    Raises the first fault where none can be used.
    """
    import numpy as np

    from emg2vsa.extraction.join import join_trials

    given_settings = dict(given.settings)
    further, visits, _ = (given_settings.pop(name) for name in ("further", "visits", "muscles"))
    if given.files["mvc"]:
        given_settings["cocontraction"] = _with_contractions(given.files["mvc"], given_settings)
    parts = [(given_settings.pop("channels"), given_settings.pop("fault")), *further]
    made: list[Trials] = []
    names: list[str] = []
    used: list[tuple[Path, ChannelSettings]] = []
    faults: list[Emg2vsaError] = []
    for number, (channels, fault) in enumerate(parts, 1):
        emg = given.files[_role("emg", number)][0]
        try:
            trials = _part(given, number, channels, fault, given_settings)
            _refuse_copy(emg, [file for file, its in used if its == channels])
            if visit := visits[number - 1]:
                trials = replace(trials, visit=np.full(trials.repetition.size, visit))
            join_trials([*made[:1], trials], [*names[:1], str(emg)])
        except PassingError:
            raise
        except Emg2vsaError as error:
            faults.append(error)
        else:
            made.append(trials)
            names.append(str(emg))
            used.append((emg, channels))
    if not made:
        raise faults[0]
    joined = join_trials(made, names)
    return replace(joined, remarks=(*joined.remarks, *(f"{NOT_USED}{fault}" for fault in faults)))


def _refuse_copy(file: Path, others: Sequence[Path]) -> None:
    """RecordingError where the bytes are those of another recording of the item: its presses would count twice."""
    for other in others:
        if same_samples(file, other):
            found = f"the same recording as {other.name}, byte by byte"
            do = "Take one of the two out of the folder, or export the right one again."
            raise RecordingError(file, wanted="a recording of its own", found=found, do=do)


def _part(given: Given, number: int, channels: ChannelSettings, fault: str, shared: dict[str, Any]) -> Trials:
    participant, _, specimen = given.item.partition("/")
    (emg,), force, calibration = (given.files[_role(name, number)] for name in ("emg", "force", "calibration"))
    if fault:
        raise RecordingError(
            emg.parent, wanted=f"one file of {given.item}" + (f", recording {number}" if number > 1 else ""),
            found=fault, do="Move what is too much away, narrow the pattern, or list the files: [[recordings.files]].",
        )  # fmt: skip
    return trials_of(
        emg, force[0] if force else None, participant, specimen, channels=channels,
        cal_file=calibration[0] if calibration else None, **shared,
    )  # fmt: skip


def _with_contractions(files: Sequence[Path], used: dict[str, Any]) -> CocontractionSettings:
    """The settings with the levels of recorded maximum contractions in the place of typed ones."""
    from emg2vsa.extraction.contractions import contraction_levels_v
    from emg2vsa.readers.roles import read_emg

    recordings = [read_emg(path, used["channels"], used["reading"]) for path in files]
    cocontraction: CocontractionSettings = used["cocontraction"]
    levels_v = contraction_levels_v(recordings, used["filters"])
    return replace(cocontraction, mvc_v={**cocontraction.mvc_v, **levels_v})


def trials_of(
    emg_file: Path,
    force_file: Path | None,
    participant: str,
    specimen: str,
    *,
    channels: ChannelSettings,
    filters: FilterSettings,
    window: WindowSettings,
    cocontraction: CocontractionSettings,
    reading: ReadingSettings | None = None,
    cal_file: Path | None = None,
) -> Trials:
    """Read one recording and extract its trials; ``force_file`` None means that force and EMG are in one file.

    cal_file : calibration of the transducer whose gauges the recording holds, where the force channel names one.
    Presses that do not count in the session that made the recording are rejected.

    Raises as ``read_roles`` and ``extract_trials``.
    """
    from emg2vsa.extraction.extract import extract_trials
    from emg2vsa.extraction.remedies import remedy_of
    from emg2vsa.readers.roles import read_roles
    from emg2vsa.readers.session_events import only_counted, session_presses, with_gaps

    roles = read_roles(emg_file, force_file, channels, reading, cal_file)
    emg, force, notes, began = roles.emg, [roles.force], roles.notes, roles.began
    del roles
    if (events := session_events(emg_file)) is not None:
        emg = {muscle: with_gaps(events, "EMG", channel) for muscle, channel in emg.items()}
        force = [with_gaps(events, "force", force.pop())]
    trials = extract_trials(
        emg,
        force.pop(),  # whose samples, many of a long record, nobody else holds
        participant=participant,
        specimen=specimen,
        filters=filters,
        cocontraction=cocontraction,
        window=window,
        force_channel=channels.force,
        notes=notes,
    )
    if events is not None:
        trials = only_counted(trials, session_presses(events))
    doubtful = tuple(note for note in notes if remedy_of(note))  # to be acted upon, not only recorded
    remarks = trials.remarks if trials.fault else (*doubtful, *trials.remarks)
    return replace(trials, began=began, equipment=equipment(emg_file), remarks=remarks)


def says(trials: Trials) -> str:
    loud = [note for note in trials.notes if note.startswith(LOUD)]
    return "; ".join([*loud, *(remark for remark in trials.remarks if remark.startswith(NOT_USED))])


STAGE = Stage(
    per="recording", of="people", run=run, settings=settings, files=files, says=says, alone=8,
    loads=("emg2vsa.readers.roles", "emg2vsa.extraction.extract"),
)  # fmt: skip
