"""The steps of one recording: read, condition, find the trials, fit them."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from emg2vsa import artifacts
from emg2vsa.fits import fit_trials
from emg2vsa.pipeline.tasks import Ended, guarded
from emg2vsa.readers.roles import read_roles
from emg2vsa.settings import CocontractionSettings, FitSettings
from emg2vsa.study import RecordingEntry
from emg2vsa.trials import Trials
from emg2vsa.trials.extract import extract_trials
from emg2vsa.trials.session import in_session

LOUD = "NYQUIST RULE"
"""Notes that begin so are said on screen, not only recorded: the study asked for a filter that cannot be built."""


def trials_of(entry: RecordingEntry, cocontraction: CocontractionSettings) -> Trials:
    """Read one recording and extract its trials."""
    roles = read_roles(entry.emg_file, entry.force_file, entry.channels)
    return extract_trials(
        roles.emg,
        roles.force,
        participant=entry.participant,
        specimen=entry.specimen,
        filters=entry.filters,
        cocontraction=cocontraction,
        window=entry.window,
        force_channel=entry.channels.force,
        notes=roles.notes,
    )


def run(
    entry: RecordingEntry,
    cocontraction: CocontractionSettings,
    fit: FitSettings,
    results: Mapping[str, Path],
    stages: tuple[str, ...],
    session: tuple[Path, ...],
) -> list[Ended]:
    """Make the ``stages`` asked for and store them in ``results``; fits relate to ``session``, if it holds any."""
    made: list[Trials] = []
    ended: list[Ended] = []

    def make_trials() -> str:
        made.append(trials_of(entry, cocontraction))
        artifacts.save(results["trials"], made[0])
        return "; ".join(note for note in made[0].notes if note.startswith(LOUD))

    def make_fits() -> None:
        trials = made[0] if made else artifacts.load(results["trials"])
        if session:
            trials = in_session(trials, [artifacts.load(path) for path in session], cocontraction)
        artifacts.save(results["fits"], fit_trials(trials, fit, entry.window))

    if "trials" in stages:
        ended.append(guarded(f"trials/{entry.key}", make_trials))
    if "fits" in stages and (made or "trials" not in stages):
        ended.append(guarded(f"fits/{entry.key}", make_fits))
    return ended
