"""``emg2vsa inspect`` and ``fit``: what recordings hold, and one fitted."""

from __future__ import annotations

import argparse
import dataclasses
from pathlib import Path
from typing import TYPE_CHECKING, Any

from casr.command_line import Commands, add_command, add_json, add_options, answer
from emg2vsa.cli.arguments import (
    add_channels,
    add_reading,
    channels_of,
    check_rate,
    checked_settings,
    given,
    reading_of,
)  # fmt: skip

if TYPE_CHECKING:
    from emg2vsa.errors import RecordingError
    from emg2vsa.readers.survey import FileFacts


INSPECT_SUMMARY = "Show what recordings hold: rate, unit, range and noise of every channel, and what it probably is."
INSPECT = """
For one file the command prints a line per channel, for several files or a folder a line per file. It guesses the kind
of a channel from its unit, name and samples; no other command uses this guess. Exit status 1: one of several files
could not be read. Example: emg2vsa inspect recordings --page look.html
"""
INSPECT_OPTIONS = """
files FILE...  recording, or a folder of recordings
--fs HZ  sampling rate in Hz of channels whose file does not state it
--page HTML  also write a page with pictures of every channel
"""
FIT_SUMMARY = "Find the presses of one recording and fit v = a + b ln F to each. This needs no study file."
FIT = """
Without --emg or --force the command lists the channels of the file. Exit status 1: no press was found.
Example: emg2vsa fit P01_S1.csv --emg EDC --emg FDS --force Fz --sign -1
"""
METHOD = """
--window X  force window, N (default 0.5 7)
--min-duration S  shortest loading phase, s (default 0.5)
--band X  EMG band, Hz (default 10 450)
--output-fs HZ  rate of the fitted curves, Hz (default 100)
--bin N  force bin, N (default 0.3)
--force-cutoff HZ  force low-pass, Hz (default 5)
--paper  the paper's method: causal filters, least squares on samples
"""


def add_to(commands: Commands) -> None:
    parser = add_command(commands, "inspect", inspect, INSPECT_SUMMARY, INSPECT, INSPECT_OPTIONS, {"HTML": Path})
    add_reading(parser)
    add_json(parser)
    file = "file FILE  recording: CSV, text, EMGworks, Discover, C3D, EDF, BDF, .mat"
    parser = add_command(commands, "fit", fit, FIT_SUMMARY, FIT, file)
    add_channels(parser)
    add_reading(parser)
    two = {"nargs": 2, "metavar": ("LOW", "HIGH")}
    add_options(parser.add_argument_group("method"), METHOD, {"N": float}, window=two, band=two)
    add_json(parser)


def inspect(arguments: argparse.Namespace) -> int:
    from casr.atomic import write_text_atomic
    from emg2vsa.errors import RecordingError
    from emg2vsa.pipeline.places import recordings_in
    from emg2vsa.report.recordings import as_json, file_lines, folder_lines

    check_rate(arguments.fs)
    paths = recordings_in(arguments.files)
    alone = len(paths) == 1 and not arguments.files[0].is_dir()
    outcomes = _outcomes(arguments, paths, alone)
    found = [each for each in outcomes if not isinstance(each, RecordingError)]
    refused = [each for each in outcomes if isinstance(each, RecordingError)]
    if alone:
        answer(arguments.json, as_json(found[0]), file_lines(found[0]))
    else:
        unread = [{"file": error.where, "found": error.found, "do": error.do} for error in refused]
        told = {"files": [as_json(facts) for facts in found], "refused": unread}
        answer(arguments.json, told, folder_lines(paths, outcomes))
    if arguments.page is not None:
        from emg2vsa.report.recordings import recording_page

        write_text_atomic(arguments.page, recording_page(found, [str(error) for error in refused]))
        if not arguments.json:
            print(f"Page: {arguments.page}")
    return int(bool(refused))


def _outcomes(arguments: argparse.Namespace, paths: list[Path], alone: bool) -> list[FileFacts | RecordingError]:
    """What each file holds, or why it cannot be read; where it is the only one, that is raised."""
    from emg2vsa.errors import RecordingError
    from emg2vsa.readers.survey import survey

    reading = reading_of(arguments, "inspect")
    outcomes: list[FileFacts | RecordingError] = []
    for path in paths:
        try:
            facts = survey(path, reading, arguments.fs)
            # a folder may be larger than the memory
            outcomes.append(facts if arguments.page or alone else dataclasses.replace(facts, stored=()))
        except RecordingError as error:
            if alone:
                raise
            outcomes.append(error)
    return outcomes


def fit(arguments: argparse.Namespace) -> int:
    if not arguments.emg or arguments.force is None:
        return _list_channels(arguments)
    from emg2vsa.companions.law_misfit import cell_misfits, compare_misfits
    from emg2vsa.companions.person_slopes import person_slopes
    from emg2vsa.fits import fit_trials
    from emg2vsa.pipeline.stages.trials import trials_of
    from emg2vsa.report.recordings import fit_lines, rows
    from emg2vsa.settings import CocontractionSettings

    settings = _settings(arguments)
    fit, file = settings.pop("fit"), arguments.file
    trials = trials_of(file, arguments.force_file, file.stem, "", cocontraction=CocontractionSettings(), **settings)
    fits = fit_trials(trials, fit, settings["window"])
    law = compare_misfits(cell_misfits(fits, "ok")).said(fits.activity_unit)
    people = person_slopes(fits, "ok")
    told = {
        "file": str(file), "notes": list(trials.notes), "law": law, "b": people.rows(), "trials": rows(trials, fits),
    }  # fmt: skip
    answer(arguments.json, told, fit_lines(trials, fits, *people.said(fits.activity_unit), law))
    return 0 if trials.repetition.size else 1


def _settings(arguments: argparse.Namespace) -> dict[str, Any]:
    """The settings of each stage, checked as a study file's are."""
    from emg2vsa.settings import PAPER, ChannelSettings, FilterSettings, FitSettings, WindowSettings

    paper, band, cutoff = PAPER if arguments.paper else {}, arguments.band, arguments.force_cutoff
    filters = {"band_hz": band, "output_fs_hz": arguments.output_fs, "force_cutoff_hz": cutoff}
    window = {"force_n": arguments.window, "min_duration_s": arguments.min_duration}
    asked = {
        "channels": (ChannelSettings, channels_of(arguments)),
        "filters": (FilterSettings, {**paper.get("filters", {}), **given(filters)}),
        "window": (WindowSettings, {**paper.get("window", {}), **given(window)}),
        "fit": (FitSettings, {**paper.get("fit", {}), **given({"bin_n": arguments.bin})}),
    }
    return checked_settings("fit", asked) | {"reading": reading_of(arguments, "fit")}


def _list_channels(arguments: argparse.Namespace) -> int:
    from emg2vsa.readers.front_door import open_recording
    from emg2vsa.report.recordings import channel_lines

    name, opened = open_recording(arguments.file, reading_of(arguments, "fit"))
    channels, notes = opened.describe(), list(opened.contents.notes)
    absent = [f"--{option} CHANNEL" for option in ("emg", "force") if not getattr(arguments, option)]
    told = {"format": name, "channels": [vars(channel) for channel in channels], "notes": notes}
    answer(arguments.json, told, channel_lines(arguments.file, name, channels, notes, absent))
    return 0
