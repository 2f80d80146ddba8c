"""A synthetic study as a BIDS dataset (BIDS-EMG, 1.11.1): recordings with side files, and the dataset around them."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

from casr.atomic import write_bytes_atomic, write_text_atomic
from emg2vsa import __version__
from emg2vsa.bids import CHANNEL_COLUMNS, MUSCLES, BdfChannel, Json, bdf_bytes, description, write_json, write_tsv
from emg2vsa.errors import SettingError
from emg2vsa.settings import SimulationSettings
from emg2vsa.study import Study
from emg2vsa.synthetic.carrier import AMPLIFIER_BAND_HZ
from emg2vsa.synthetic.plan import PlannedRecording
from emg2vsa.synthetic.recording import SyntheticRecording
from emg2vsa.synthetic.stored import StoredChannel, stored_channels


def check_labels(plan: Sequence[PlannedRecording]) -> None:
    """BIDS labels are letters and digits only; refuse names that are not, before anything is written."""
    for name in dict.fromkeys(name for planned in plan for name in (planned.participant, planned.specimen)):
        if not re.fullmatch(r"[A-Za-z0-9]+", name):
            raise SettingError(
                f"name {name!r}",
                wanted="letters and digits only, for it becomes a BIDS label",
                found=repr(name),
                do="Rename it, or write another format.",
            )


def write_bids(folder: Path, planned: PlannedRecording, recording: SyntheticRecording) -> Path:
    """Data file of one recording, its ``_emg.json``, ``_channels.tsv`` and ``_events.tsv``; returns the data file."""
    channels = stored_channels(planned, recording, "uV")
    path = folder / _relative_path(planned)
    stem = path.name.removesuffix("_emg.bdf")
    write_bytes_atomic(path, _bdf(planned, recording, channels))
    emg = emg_json(planned.task, recording, channels, planned.mains_hz)
    write_json(path.with_suffix(".json"), emg)
    rows = [channel_row(channel, recording.fs_hz) for channel in channels]
    write_tsv(path.with_name(f"{stem}_channels.tsv"), CHANNEL_COLUMNS, rows)
    events = [(onset, "n/a", text) for onset, text in cues(recording)]
    write_tsv(path.with_name(f"{stem}_events.tsv"), ("onset", "duration", "trial_type"), events)
    return path


def write_dataset(folder: Path, study: Study, settings: SimulationSettings, plan: Sequence[PlannedRecording]) -> Path:
    """Files of the dataset as a whole, the scans files among them; returns the folder for the truth."""
    description = _description(study.title or study.name, "raw")
    write_json(folder / "dataset_description.json", description)
    write_text_atomic(folder / "README.md", readme(description["Name"], settings, len(study.specimens)))
    participants = list(dict.fromkeys(planned.participant for planned in plan))
    write_tsv(folder / "participants.tsv", ("participant_id",), [(f"sub-{name}",) for name in participants])
    write_json(folder / "participants.json", PARTICIPANT_COLUMNS)
    for task in dict.fromkeys(planned.task for planned in plan):
        write_json(folder / f"task-{task}_events.json", EVENT_COLUMNS)
    for name in participants:
        _write_scans(folder / f"sub-{name}", [planned for planned in plan if planned.participant == name])
    return _write_derivative(folder / "derivatives" / "truth", f"Truth of {description['Name']}")


def _write_derivative(folder: Path, name: str) -> Path:
    write_json(folder / "dataset_description.json", _description(name, "derivative"))
    write_text_atomic(folder / "README.md", f"# {name}\n\n{TRUTH_README}")
    # the standard has no name for tables of what was simulated
    write_text_atomic(folder / ".bidsignore", "truth.*\norder.*\n")
    return folder


def _write_scans(folder: Path, plan: Sequence[PlannedRecording]) -> None:
    in_time = sorted(plan, key=lambda planned: planned.position)
    rows = [
        (_relative_path(planned).relative_to(folder.name).as_posix(), planned.acquired.isoformat())
        for planned in in_time
    ]
    write_tsv(folder / f"{folder.name}_scans.tsv", ("filename", "acq_time"), rows)


def _relative_path(planned: PlannedRecording) -> Path:
    subject = f"sub-{planned.participant}"
    return Path(subject) / "emg" / f"{subject}_task-{planned.task}_acq-{planned.specimen}_emg.bdf"


def _description(name: str, kind: str) -> Json:
    return description(name, kind, "Synthetic recordings with known truth.", ["emg2vsa"], "CC0")


EVENT_COLUMNS: Json = {
    "onset": {"Description": "When the participant is told to act, from the start of the recording.", "Units": "s"},
    "duration": {"Description": "Not applicable: a cue has no length.", "Units": "s"},
    "trial_type": {
        "Description": "What the participant is told.",
        "Levels": {"start": "Begin to press.", "stop": "Let go."},
    },
    "StimulusPresentation": {"SoftwareName": "emg2vsa", "SoftwareVersion": __version__},
}
PARTICIPANT_COLUMNS: Json = {"participant_id": {"Description": "Simulated participant."}}
README = """\
# {title}

Synthetic recordings made by emg2vsa {version}: nobody took part. Each simulated participant presses {specimens}
soft specimens with one finger, {repetitions} times each, in one continuous recording per specimen. Surface EMG of
{muscles} and the pressing force are sampled together; specimens come in a random order, which the scans files give.

The EMG is a Gaussian carrier with the spectrum of a muscle, times an envelope that follows the force by
v = a + b ln F, plus mains hum, baseline drift and sensor noise. The force has an offset, drift and noise. What was put
in (a, b, times and forces of every press) is in `derivatives/truth`. The same settings give the same bytes.
"""

TRUTH_README = """\
What the synthetic recordings were made from: `truth.tsv` has one row per press, `order.tsv` one per recording; the JSON
files explain the columns, and `truth.json` holds the settings of the simulation.
"""


def emg_json(task: str, recording: SyntheticRecording, channels: list[StoredChannel], mains_hz: float) -> Json:
    """The ``_emg.json`` of one recording."""
    emg_count = sum(channel.muscle is not None for channel in channels)
    low, high = AMPLIFIER_BAND_HZ
    return {
        "TaskName": task,
        "TaskDescription": "Press a soft specimen with one finger, several times, with rests between.",
        "Instructions": "Press when told to start, more and more, without letting go; let go when told to stop.",
        "SamplingFrequency": recording.fs_hz,
        "PowerLineFrequency": mains_hz,
        "RecordingType": "continuous",
        "RecordingDuration": recording.duration_s,
        "EpochLength": recording.duration_s,
        "SoftwareFilters": "n/a",
        "HardwareFilters": {"Amplifier band (simulated)": {"Low cut (Hz)": low, "High cut (Hz)": high, "Order": 2}},
        "EMGReference": "bipolar",
        "EMGGround": "n/a (simulated)",
        "EMGPlacementScheme": "Other",
        "EMGPlacementSchemeDescription": "Simulated bipolar pairs over the muscle bellies; no electrode was placed.",
        "EMGChannelCount": emg_count,
        "MiscChannelCount": len(channels) - emg_count,
        "TriggerChannelCount": 0,
        "InterelectrodeDistance": 10,
        "ElectrodeMaterial": "n/a (simulated)",
        "ElectrodeType": "n/a (simulated)",
        "ElectrodeManufacturer": "n/a (simulated)",
        "ElectrodeManufacturersModelName": "n/a (simulated)",
        "Manufacturer": "emg2vsa (synthetic)",
        "ManufacturersModelName": "synthetic recording",
        "AmplifierType": "simulated",
        "DeviceSerialNumber": "n/a",
        "SoftwareVersions": f"emg2vsa {__version__}",
        "SubjectArtefactDescription": "n/a",
        "InstitutionName": "n/a",
        "InstitutionAddress": "n/a",
        "InstitutionalDepartmentName": "n/a",
    }


def channel_row(channel: StoredChannel, fs_hz: float) -> tuple[object, ...]:
    """Cells in the order of ``CHANNEL_COLUMNS``."""
    head = (channel.name, "EMG" if channel.muscle else "MISC", channel.unit or "n/a")
    tail = ("n/a", "good", "n/a")
    if channel.muscle is None:
        return (*head, "pressing force", fs_hz, *["n/a"] * 9, *tail)
    muscle = MUSCLES.get(channel.muscle, channel.muscle)
    placed = ("other", f"belly of the {muscle} (simulated)", 10, *AMPLIFIER_BAND_HZ)
    electrodes = (f"{channel.muscle}1", f"{channel.muscle}2", channel.muscle)
    return (*head, f"surface EMG of {channel.muscle}", fs_hz, *electrodes, muscle, *placed, *tail)


def readme(title: str, settings: SimulationSettings, specimens: int) -> str:
    muscles = " and ".join(MUSCLES.get(muscle, muscle) for muscle in settings.muscle_share)
    return README.format(
        title=title, version=__version__, specimens=specimens, repetitions=settings.repetitions, muscles=muscles
    )


def _bdf(planned: PlannedRecording, recording: SyntheticRecording, channels: list[StoredChannel]) -> bytes:
    """A recording as BDF+, its cues as annotations."""
    if not float(recording.fs_hz).is_integer():
        raise SettingError(
            "simulation.fs_hz",
            wanted="whole samples a second, for BDF stores whole seconds",
            found=f"{recording.fs_hz:g} Hz",
            do="Round it, or write another format.",
        )
    return bdf_bytes(
        [
            BdfChannel(
                channel.name, channel.samples, channel.unit, recording.fs_hz,
                "force sensor" if channel.muscle is None else "bipolar surface electrode",
            )
            for channel in channels
        ],
        [(onset, None, text) for onset, text in cues(recording)],
        patient=planned.participant, equipment="emg2vsa-synthetic", record_s=1.0, started=planned.acquired,
    )  # fmt: skip


def cues(recording: SyntheticRecording) -> list[tuple[float, str]]:
    """(seconds to the millisecond, "start" or "stop"), in time order: what the participant is told."""
    presses = recording.truth.presses
    start = [(round(float(onset), 3), "start") for onset in presses.cue_start_s]
    stop = [(round(float(onset), 3), "stop") for onset in presses.cue_stop_s]
    return sorted(start + stop)
