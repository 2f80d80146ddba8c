"""``emg2vsa inspect``: what recordings hold, and what each channel probably is."""

from __future__ import annotations

import argparse
import dataclasses
from pathlib import Path
from typing import TYPE_CHECKING

from casr.command_line import Commands, add_command, add_json, answer
from emg2vsa.cli.arguments import add_reading, check_rate, reading_of

if TYPE_CHECKING:
    from emg2vsa.errors import RecordingError
    from emg2vsa.readers.survey import FileFacts

SUMMARY = "Show what recordings hold: rate, unit, range and noise of every channel, and what it probably is."
EPILOG = """
For one file the command prints a line per channel, for several files or a folder a line per file. It guesses the kind
of a channel from its unit, name and samples; no other command uses this guess. Exit status 1: one of several files
could not be read. Example: emg2vsa inspect recordings --page look.html
"""
OPTIONS = """
files FILE...  recording, or a folder of recordings
--fs HZ  sampling rate in Hz of channels whose file does not state it
--page HTML  also write a page with pictures of every channel
"""


def add_to(commands: Commands) -> None:
    parser = add_command(commands, "inspect", run, SUMMARY, EPILOG, OPTIONS, {"HTML": Path})
    add_reading(parser)
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    from casr.atomic import write_text_atomic
    from emg2vsa.errors import RecordingError
    from emg2vsa.pipeline.found_recordings import recordings_in
    from emg2vsa.report.recording_words import as_json, file_lines, folder_lines

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
        from emg2vsa.report.recording_page import recording_page

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
