"""A synthetic study as a BIDS dataset: what its recordings and the dataset around them hold."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from emg2vsa import __version__
from emg2vsa.bids.dataset import DataSet, write_dataset, write_scans
from emg2vsa.bids.names import RecordingName, is_label
from emg2vsa.bids.recording import Channel, Event, Recording, event_columns, muscle_name, told_of_screen
from emg2vsa.bids.recording_files import write_recording
from emg2vsa.bids.tables import Column, described
from emg2vsa.errors import SettingError
from emg2vsa.settings import SimulationSettings
from emg2vsa.study import Study
from emg2vsa.worlds.people.formats import stored_channels
from emg2vsa.worlds.people.plan import PlannedRecording
from emg2vsa.worlds.people.recording import SyntheticRecording
from emg2vsa.worlds.people.signals import AMPLIFIER_BAND_HZ

_MADE = "Synthetic recordings with known truth."
_ELECTRODE_MM = 10
_LOW_HZ, _HIGH_HZ = AMPLIFIER_BAND_HZ
_CUES = event_columns(
    "When the participant is told to act, from the start of the recording.",
    "Not applicable: a cue has no length.",
    Column("What the participant is told.", levels={"start": "Begin to press.", "stop": "Let go."}),
)
_HOW = {
    "instructions": "Press when told to start, more and more, without letting go; let go when told to stop.",
    "hardware_filters": {
        "Amplifier band (simulated)": {"Low cut (Hz)": _LOW_HZ, "High cut (Hz)": _HIGH_HZ, "Order": 2}
    },
    "placement": "Simulated bipolar pairs over the muscle bellies; no electrode was placed.",
    "manufacturer": "emg2vsa (synthetic)",
    "model": "synthetic recording",
    "amplifier_type": "simulated",
    **dict.fromkeys(
        ("ground", "electrode_material", "electrode_type", "electrode_manufacturer", "electrodes"), "n/a (simulated)"
    ),
    **dict.fromkeys(("serial", "subject_artefact_description", "institution", "institution_address"), "n/a"),
    "institutional_department_name": "n/a",
}
_README = """\
Synthetic recordings made by emg2vsa {version}: nobody took part. Each simulated participant presses {specimens}
soft specimens with one finger, {repetitions} times each, in one continuous recording per specimen. Surface EMG of
{muscles} and the pressing force are sampled together; specimens come in a random order, which the scans files give.

The EMG is a Gaussian carrier with the spectrum of a muscle, times an envelope that follows the force by
v = a + b ln F, plus mains hum, baseline drift and sensor noise. The force has an offset, drift and noise. What was put
in (a, b, times and forces of every press) is in `derivatives/truth`. The same settings give the same bytes.
"""
_TRUTH_README = """\
What the synthetic recordings were made from: `truth.tsv` has one row per press, `order.tsv` one per recording; the JSON
files explain the columns, and `truth.json` holds the settings of the simulation.
"""


def check_labels(plan: Sequence[PlannedRecording]) -> None:
    """BIDS labels are letters and digits only; refuse names that are not, before anything is written."""
    for name in dict.fromkeys(name for planned in plan for name in (planned.participant, planned.specimen)):
        if not is_label(name):
            raise SettingError(
                f"name {name!r}", wanted="letters and digits only, for it becomes a BIDS label", found=repr(name),
                do="Rename it, or write another format.",
            )  # fmt: skip


def write_bids(folder: Path, planned: PlannedRecording, recording: SyntheticRecording) -> Path:
    """Data file of one recording with its side files; returns the data file."""
    if not float(recording.fs_hz).is_integer():
        raise SettingError(
            "simulation.fs_hz", wanted="whole samples a second, for BDF stores whole seconds",
            found=f"{recording.fs_hz:g} Hz", do="Round it, or write another format.",
        )  # fmt: skip
    channels = [
        Channel(
            stored.name, stored.samples, stored.unit, recording.fs_hz, stored.muscle, stated_hz=str(recording.fs_hz),
            pair=stored.muscle or "", placed=" (simulated)", band_hz=AMPLIFIER_BAND_HZ,
        )
        for stored in stored_channels(planned, recording, "uV")
    ]  # fmt: skip
    return write_recording(
        folder,
        Recording(
            _name(planned), channels, recording.fs_hz, recording.duration_s, record_s=1.0,
            equipment="emg2vsa-synthetic", software=f"emg2vsa {__version__}", events=_cues(recording), columns=_CUES,
            started=planned.acquired, mains_hz=planned.mains_hz, electrode_mm=_ELECTRODE_MM,
            how={"epoch_length": recording.duration_s, **_HOW},
        ),
    )  # fmt: skip


def write_around(folder: Path, study: Study, settings: SimulationSettings, plan: Sequence[PlannedRecording]) -> Path:
    """Files of the dataset as a whole, the scans files among them; returns the folder for the truth."""
    name = study.title or study.name
    muscles = " and ".join(map(muscle_name, settings.muscle_share))
    readme = _README.format(
        version=__version__, specimens=len(study.specimens), repetitions=settings.repetitions, muscles=muscles
    )
    participants = list(dict.fromkeys(planned.participant for planned in plan))
    told = described(_CUES) | told_of_screen(software_version=__version__)
    whole = DataSet(
        name, _MADE, readme, participants=participants, participant="Simulated participant.",
        events={planned.task: told for planned in plan}, authors=["emg2vsa"], licence="CC0",
    )  # fmt: skip
    write_dataset(folder, whole)
    for participant in participants:
        own = [planned for planned in plan if planned.participant == participant]
        write_scans(folder, participant, {_name(one): one.acquired.isoformat() for one in own})
    truth = folder / "derivatives" / "truth"
    # the standard has no name for tables of what was simulated
    of_truth = DataSet(
        f"Truth of {name}", _MADE, _TRUTH_README, "derivative", authors=["emg2vsa"], licence="CC0",
        ignored=("truth.*", "order.*"),
    )  # fmt: skip
    write_dataset(truth, of_truth)
    return truth


def _name(planned: PlannedRecording) -> RecordingName:
    return RecordingName(planned.participant, planned.task, planned.specimen)


def _cues(recording: SyntheticRecording) -> list[Event]:
    """What the participant is told, in time order, to the millisecond."""
    presses = recording.truth.presses
    told = [("start", onset) for onset in presses.cue_start_s] + [("stop", onset) for onset in presses.cue_stop_s]
    events = [Event(round(float(onset), 3), None, what) for what, onset in told]
    return sorted(events, key=lambda event: (event.onset_s, event.kind))
