"""Trials: read one recording, condition it, find its presses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from emg2vsa.pipeline.stage import Given, Stage
from emg2vsa.readers.bids_sidecars import side_file_paths

if TYPE_CHECKING:
    from emg2vsa.pipeline.campaign import Campaign
    from emg2vsa.settings import ChannelSettings, CocontractionSettings, FilterSettings, ReadingSettings, WindowSettings
    from emg2vsa.trials import Trials

LOUD = "NYQUIST RULE"
"""Notes that begin so are said on screen, not only recorded: the study asked for a filter that cannot be built."""


def settings(campaign: Campaign, item: str) -> dict[str, Any]:
    entry = campaign.recordings[item]
    return {
        "channels": entry.channels,
        "filters": entry.filters,
        "window": entry.window,
        "cocontraction": campaign.study.cocontraction,
        "reading": campaign.study.reading,
    }


def files(campaign: Campaign, item: str) -> dict[str, Sequence[Path]]:
    entry = campaign.recordings[item]
    own = (entry.emg_file, entry.force_file) if entry.force_file else (entry.emg_file,)
    sides = [side for path in own for side in side_file_paths(path, campaign.side_files)]
    return {"emg": own[:1], "force": own[1:], "mvc": entry.mvc_files, "beside": sides}


def run(given: Given) -> Trials:
    participant, _, specimen = given.item.partition("/")
    force = given.files["force"]
    used = dict(given.settings)
    if given.files["mvc"]:
        used["cocontraction"] = _with_contractions(given.files["mvc"], **used)
    return trials_of(given.files["emg"][0], force[0] if force else None, participant, specimen, **used)


def _with_contractions(
    files: Sequence[Path],
    *,
    channels: ChannelSettings,
    filters: FilterSettings,
    cocontraction: CocontractionSettings,
    reading: ReadingSettings,
    window: WindowSettings,
) -> CocontractionSettings:
    """The settings with the levels of recorded maximum contractions in the place of typed ones."""
    from emg2vsa.readers.roles import read_emg
    from emg2vsa.trials.contractions import contraction_levels_v

    levels_v = contraction_levels_v([read_emg(path, channels, reading) for path in files], filters)
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
) -> Trials:
    """Read one recording and extract its trials; ``force_file`` None means that force and EMG are in one file.

    Raises as ``read_roles`` and ``extract_trials``.
    """
    from emg2vsa.readers.roles import read_roles
    from emg2vsa.trials.extract import extract_trials

    roles = read_roles(emg_file, force_file, channels, reading)
    return extract_trials(
        roles.emg,
        roles.force,
        participant=participant,
        specimen=specimen,
        filters=filters,
        cocontraction=cocontraction,
        window=window,
        force_channel=channels.force,
        notes=roles.notes,
    )


def says(trials: Trials) -> str:
    return "; ".join(note for note in trials.notes if note.startswith(LOUD))


STAGE = Stage(per="recording", of="people", run=run, settings=settings, files=files, says=says, alone=8)
