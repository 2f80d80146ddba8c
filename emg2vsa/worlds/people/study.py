"""Whole studies whose truth is known, as a BIDS dataset unless another format is asked for.

The truth travels beside them, one row per press and one per recording.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Literal

from emg2vsa import __version__
from emg2vsa.bids.dataset import DataSet, write_dataset, write_scans
from emg2vsa.bids.names import RecordingName, is_label
from emg2vsa.bids.recording import Channel, Event, Recording, event_columns, muscle_name, told_of_screen
from emg2vsa.bids.recording_files import write_recording
from emg2vsa.bids.tables import Column, Json, described, write_json, write_tsv
from emg2vsa.errors import SettingError
from emg2vsa.settings import SimulationSettings
from emg2vsa.study import Study
from emg2vsa.worlds import VERSION
from emg2vsa.worlds.people.formats import stored_channels, write_c3d, write_csv, write_emgworks
from emg2vsa.worlds.people.plan import PlannedRecording, plan_study
from emg2vsa.worlds.people.recording import SyntheticRecording
from emg2vsa.worlds.people.signals import AMPLIFIER_BAND_HZ

Format = Literal["bids", "csv", "emgworks", "c3d"]
Progress = Callable[[int, int, str], None]

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
PRESS_COLUMNS = {
    "participant": "Participant of the study.",
    "specimen": "Specimen that was pressed.",
    "repetition": "Press within the recording, 1-based, in time order.",
    "a_v": "True intercept of v = a + b ln(F / 1 N), volts.",
    "b_v": "True slope, volts per natural-log newton.",
    "onset_s": "Last rise of the true force through the window's lower force before it reaches the upper, seconds.",
    "stop_s": "First reach of the window's upper force, seconds.",
    "peak_force_n": "Largest true force of the press, newtons.",
    "largest_fall_n": "Deepest fall of the true force below its running maximum between onset and stop, newtons.",
}
RECORDING_COLUMNS = {
    "participant": "Participant of the study.",
    "order": "Place of the specimen in the participant's random order, 1-based.",
    "specimen": "Specimen that was pressed.",
    "acq_time": "Nominal start of the recording.",
    "duration_s": "Length of the recording, seconds.",
    "force_offset_n": "Bias of the force sensor over the recording, newtons (compression positive).",
}

Row = tuple[object, ...]


@dataclass(frozen=True)
class SimulatedStudy:
    """What was written. recordings : one per participant and specimen, in that order; truth : table of presses."""

    folder: Path
    format: str
    recordings: tuple[Path, ...]
    truth: Path


def simulate_study(
    study: Study, folder: Path, *, format: Format = "bids", progress: Progress | None = None
) -> SimulatedStudy:
    """Simulate every recording of the study and write it under ``folder``, each file whole or not at all.

    The same settings give the same bytes; each recording depends on the seed, its own settings and the places of its
    participant and specimen in the study, and on nothing else. progress is called as (done, total, recording).

    Raises SettingError: no simulation settings, or settings that do not fit the study or the format.
    """
    if format not in WRITERS:
        raise SettingError("format", wanted=" or ".join(WRITERS), found=repr(format), do="Choose one of these.")
    settings, plan = plan_study(study)
    if format == "bids":
        check_labels(plan)
    files, presses, rows = [], [], []
    for done, planned in enumerate(plan):
        if progress is not None:
            progress(done, len(plan), f"{planned.participant}/{planned.specimen}")
        recording = planned.make(settings)
        files.append(WRITERS[format](folder, planned, recording))
        presses += press_rows(planned, recording)
        rows.append(recording_row(planned, recording))
    truth_folder = folder
    if format == "bids":
        truth_folder = write_around(folder, study, settings, plan)
    truth = write_truth(truth_folder, settings, presses, rows)
    if progress is not None:
        progress(len(plan), len(plan), "truth")
    return SimulatedStudy(folder, format, tuple(files), truth)


def press_rows(planned: PlannedRecording, recording: SyntheticRecording) -> list[Row]:
    """One row per press, cells in the order of ``PRESS_COLUMNS``."""
    truth, presses = recording.truth, recording.truth.presses
    columns = (truth.a_v, truth.b_v, presses.onset_s, presses.stop_s, presses.peak_force_n, presses.largest_fall_n)
    numbers = zip(*(column.tolist() for column in columns), strict=True)
    return [
        (planned.participant, planned.specimen, repetition, *cells) for repetition, cells in enumerate(numbers, start=1)
    ]


def recording_row(planned: PlannedRecording, recording: SyntheticRecording) -> Row:
    """Cells in the order of ``RECORDING_COLUMNS``."""
    return (
        planned.participant,
        planned.position,
        planned.specimen,
        planned.acquired.isoformat(),
        recording.duration_s,
        recording.truth.force_offset_n,
    )


def write_truth(folder: Path, settings: SimulationSettings, presses: Sequence[Row], recordings: Sequence[Row]) -> Path:
    """``truth.tsv`` and ``order.tsv`` (in order of acquisition), each with a JSON file that explains its columns.

    Returns the first of them.
    """
    participants = list(dict.fromkeys(row[0] for row in recordings))
    in_time = sorted(recordings, key=lambda row: (participants.index(row[0]), row[1]))
    _write_table(folder / "truth", PRESS_COLUMNS, presses, {"Simulation": asdict(settings), "World": VERSION})
    _write_table(folder / "order", RECORDING_COLUMNS, in_time, {})
    return folder / "truth.tsv"


def _write_table(stem: Path, columns: Mapping[str, str], rows: Sequence[Row], more: Json) -> None:
    write_tsv(stem.with_suffix(".tsv"), columns, rows)
    write_json(stem.with_suffix(".json"), described({name: Column(said) for name, said in columns.items()}) | more)


def check_labels(plan: Sequence[PlannedRecording]) -> None:
    """BIDS labels are letters and digits only; refuse names that are not, before anything is written."""
    for name in dict.fromkeys(name for planned in plan for name in (planned.participant, planned.specimen)):
        if not is_label(name):
            raise SettingError(
                f"name {name!r}", wanted="letters and digits only, for it becomes a BIDS label", found=repr(name),
                do="Rename it, or write another format.",
            )  # fmt: skip


def write_bids(folder: Path, planned: PlannedRecording, recording: SyntheticRecording) -> Path:
    """Data file of one recording with its side files; returns the data file.

    SettingError : a rate that is no whole number, which BDF cannot store.
    """
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


WRITERS: dict[str, Callable[[Path, PlannedRecording, SyntheticRecording], Path]] = {
    "bids": write_bids,
    "csv": write_csv,
    "emgworks": write_emgworks,
    "c3d": write_c3d,
}
