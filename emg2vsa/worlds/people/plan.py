"""Who is recorded on what, when, and with which coefficients: everything random about a study except its signals."""

from __future__ import annotations

import re
from dataclasses import dataclass
from datetime import datetime, timedelta
from typing import Literal

import numpy as np

from emg2vsa.errors import SettingError
from emg2vsa.settings import ChannelSettings, SimulationSettings, WindowSettings
from emg2vsa.study import RecordingEntry, Study
from emg2vsa.worlds.people.person import check_coefficients, participant_factor
from emg2vsa.worlds.people.recording import RecordingStream, SyntheticRecording, longest_record_s

FIRST_SESSION = datetime(2026, 1, 5, 9, 0, 0)
"The first participant's first recording; the others follow, one participant a day. No clock is read."
SLOT_S = 300
"Recordings of one session begin at multiples of this time, where none lasts longer."


@dataclass(frozen=True)
class PlannedRecording:
    """One recording to make. ``position`` is its 1-based place in the participant's random order of specimens;
    ``task`` the BIDS task label of the study's file name, if that has one.
    """

    participant: str
    specimen: str
    channels: ChannelSettings
    window: WindowSettings
    a_v: float
    b_v: float
    mains_hz: float
    task: str
    position: int
    acquired: datetime
    seed: np.random.SeedSequence

    def make(self, settings: SimulationSettings) -> SyntheticRecording:
        """Its signals and truth; the same every time."""
        window_n, delay_s = self.window.force_n, self.channels.force.delay_s
        given = {"a_v": self.a_v, "b_v": self.b_v, "force_delay_s": delay_s}
        return RecordingStream(self.seed, settings, window_n=window_n, **given).whole()


def plan_study(study: Study) -> tuple[SimulationSettings, tuple[PlannedRecording, ...]]:
    """Every recording of the study, participants in order, specimens in order.

    Raises SettingError where the study has no simulation settings, or EMG would not rise with force.
    """
    settings = _checked_settings(study)
    longest_s = max((longest_record_s(settings, entry.window.force_n) for entry in study.recordings), default=0.0)
    slot = timedelta(seconds=SLOT_S * -(-longest_s // SLOT_S))
    sessions = [_session(study, settings, index, slot) for index in range(len(study.participants))]
    return settings, tuple(planned for session in sessions for planned in session)


def _session(study: Study, settings: SimulationSettings, index: int, slot: timedelta) -> list[PlannedRecording]:
    """The recordings of one participant, specimens in the study's order."""
    factor, rng = participant_factor(settings, index)
    places = np.argsort(rng.random(len(study.specimens))).argsort().tolist()
    participant = study.participants[index]
    entries = {entry.specimen: entry for entry in study.recordings if entry.participant == participant}
    return [
        PlannedRecording(
            participant=participant,
            specimen=specimen.name,
            channels=entries[specimen.name].channels,
            window=entries[specimen.name].window,
            a_v=settings.a_v[specimen.name] * factor,
            b_v=settings.b_v[specimen.name] * factor,
            mains_hz=settings.mains_hz,
            task=_task(entries[specimen.name]),
            position=place + 1,
            acquired=FIRST_SESSION + timedelta(days=index) + place * slot,
            seed=np.random.SeedSequence(settings.seed, spawn_key=(index, number)),
        )
        for number, (specimen, place) in enumerate(zip(study.specimens, places, strict=True))
        if specimen.name in entries
    ]


def _task(entry: RecordingEntry) -> str:
    label = re.search(r"_task-([A-Za-z0-9]+)_", entry.emg_file.name)
    return label[1] if label else "palpation"


def _checked_settings(study: Study) -> SimulationSettings:
    """The settings; what else they must fit, the study file has been checked for."""
    settings = study.simulation
    if settings is None:
        raise SettingError(
            f"{study.path}, [simulation]", wanted="simulation settings", found="none", do="Add a [simulation] table."
        )
    for entry in study.recordings:
        where = f"{study.path}, simulation, specimen {entry.specimen}"
        check_coefficients(where, settings.a_v[entry.specimen], settings.b_v[entry.specimen], entry.window.force_n[0])
    return settings


def format_of(study: Study) -> Literal["bids", "csv", "c3d"]:
    """The format that the study's file names ask for."""
    suffix = study.recordings[0].emg_file.suffix.lower()
    return "c3d" if suffix == ".c3d" else "csv" if suffix == ".csv" else "bids"
