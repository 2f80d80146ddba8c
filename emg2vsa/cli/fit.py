"""``emg2vsa fit``: one recording, no study; its presses and their fits v = a + b ln F."""

from __future__ import annotations

import argparse
from typing import Any

from casr.command_line import Commands, add_command, add_json, add_options, answer
from emg2vsa.cli.arguments import add_channels, add_reading, channels_of, checked_settings, given, reading_of

SUMMARY = "Find the presses of one recording and fit v = a + b ln F to each. This needs no study file."
EPILOG = """
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
    file = "file FILE  recording: CSV, text, EMGworks, Discover, C3D, EDF, BDF, .mat"
    parser = add_command(commands, "fit", run, SUMMARY, EPILOG, file)
    add_channels(parser)
    add_reading(parser)
    two = {"nargs": 2, "metavar": ("LOW", "HIGH")}
    add_options(parser.add_argument_group("method"), METHOD, {"N": float}, window=two, band=two)
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    if not arguments.emg or arguments.force is None:
        return _list_channels(arguments)
    from emg2vsa.fits import fit_trials
    from emg2vsa.pipeline.stages.trials import trials_of
    from emg2vsa.report.fit_words import fit_lines, rows
    from emg2vsa.settings import CocontractionSettings

    settings = _settings(arguments)
    fit, file = settings.pop("fit"), arguments.file
    trials = trials_of(file, arguments.force_file, file.stem, "", cocontraction=CocontractionSettings(), **settings)
    fits = fit_trials(trials, fit, settings["window"])
    told = {"file": str(file), "notes": list(trials.notes), "trials": rows(trials, fits)}
    answer(arguments.json, told, fit_lines(trials, fits))
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
    from emg2vsa.report.fit_words import channel_lines

    name, opened = open_recording(arguments.file, reading_of(arguments, "fit"))
    channels, notes = opened.describe(), list(opened.contents.notes)
    absent = [f"--{option} CHANNEL" for option in ("emg", "force") if not getattr(arguments, option)]
    told = {"format": name, "channels": [vars(channel) for channel in channels], "notes": notes}
    answer(arguments.json, told, channel_lines(arguments.file, name, channels, notes, absent))
    return 0
