"""``emg2vsa tools convert``: own recordings as a BIDS-EMG data set."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

from casr.command_line import Commands, add_command, add_json, answer
from emg2vsa.cli.arguments import add_channels, add_reading, reading_of, recording_of

SUMMARY = "Write recordings as a BIDS-EMG data set: BDF+ files with tables of channels, presses and recording details."
EPILOG = """
Give a study file to convert all its recordings, or one recording and the names of its channels as for emg2vsa fit. EMG
is stored in uV, force in N, each at its own rate. The originals are not changed. Exit status 1: a recording could not
be converted. Example: emg2vsa tools convert study.toml --out shared --mains 50 --electrode-distance 10
"""
OPTIONS = """
source SOURCE  study file (.toml), or one recording
--out DIR  folder of the data set; it must be empty or absent
--task LABEL = palpation  BIDS task label (default palpation)
--mains {50,60}  mains frequency of the place of recording, Hz
--electrode-distance MM  distance between the two electrodes of a pair, mm
--about JSON  JSON file with more keys for every _emg.json, such as Manufacturer
--participant ID  for one recording: code of the participant
--specimen NAME  for one recording: name of the specimen
"""


def add_to(commands: Commands) -> None:
    more: dict[str, Any] = {"out": {"required": True}, "mains": {"type": int, "choices": (50, 60)}}
    types = {"SOURCE": Path, "JSON": Path, "MM": float}
    parser = add_command(commands, "convert", run, SUMMARY, EPILOG, OPTIONS, types, **more)
    add_channels(parser)
    add_reading(parser)
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    from emg2vsa.cli.progress import counter, progress
    from emg2vsa.pipeline.bids_about import about
    from emg2vsa.pipeline.bids_export import export
    from emg2vsa.pipeline.judged_sessions import fits_of
    from emg2vsa.settings import CocontractionSettings
    from emg2vsa.study_file import load_study

    said = about(arguments.task, arguments.mains, arguments.electrode_distance, arguments.about)
    told: dict[str, Any] = {"progress": None if arguments.json else counter("convert")}
    if arguments.source.suffix.lower() == ".toml":
        study = load_study(arguments.source)
        name, entries = study.title, study.recordings
        told |= {"base": study.path.parent, "cocontraction": study.cocontraction, "reading": study.reading}
        told |= {"fits": fits_of(study, progress(quiet=arguments.json))}
    else:
        name, entries = arguments.source.stem, (recording_of(arguments, "convert"),)
        told |= {"base": Path(), "cocontraction": CocontractionSettings(), "reading": reading_of(arguments, "convert")}
    done = export(arguments.out, name, entries, said, **told)
    for key, message in () if arguments.json else done.failures:
        print(f"not converted: {key}: {message}", file=sys.stderr)
    files = [str(path) for path in done.files]
    failures = [{"recording": key, "message": message} for key, message in done.failures]
    found = {"folder": str(arguments.out), "recordings": files, "failures": failures, "notes": done.notes}
    last = f"{len(files)} recording{'s' if len(files) != 1 else ''} in {arguments.out}"
    answer(arguments.json, found, [*(f"note: {note}" for note in done.notes), last])
    return int(bool(failures))
