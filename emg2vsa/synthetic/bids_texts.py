"""What the side files of a synthetic BIDS-EMG dataset say (BIDS 1.11.1, electromyography)."""

from __future__ import annotations

from typing import Any

from emg2vsa import __version__
from emg2vsa.settings import SimulationSettings
from emg2vsa.synthetic.carrier import AMPLIFIER_BAND_HZ
from emg2vsa.synthetic.recording import SyntheticRecording
from emg2vsa.synthetic.stored import StoredChannel

Json = dict[str, Any]

GENERATED_BY = [{"Name": "emg2vsa", "Version": __version__, "Description": "Synthetic recordings with known truth."}]
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


CHANNEL_COLUMNS = (
    "name", "type", "units", "description", "sampling_frequency", "signal_electrode", "reference", "group",
    "target_muscle", "placement_scheme", "placement_description", "interelectrode_distance", "low_cutoff",
    "high_cutoff", "notch", "status", "status_description",
)  # fmt: skip
MUSCLES = {"EDC": "extensor digitorum communis", "FDS": "flexor digitorum superficialis"}


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
