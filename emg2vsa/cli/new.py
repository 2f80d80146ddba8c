"""``emg2vsa new``: a study file drafted from a folder of recordings."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

from casr.command_line import Commands, add_command, add_json, answer
from emg2vsa.cli.arguments import add_reading, check_rate, reading_of

SUMMARY = "Write a first study file from a folder of recordings: people, specimens, channels, units and rates."
EPILOG = """
The command guesses everything from the names and the contents of the files, and marks each guess. On a terminal it asks
for what no file tells; otherwise it marks the line FILL IN. It never replaces an existing file. Example: emg2vsa new
recordings --stiffness hard=6.0 --stiffness soft=1.5
"""
OPTIONS = """
folder FOLDER  folder of recordings
--out FILE  study file to write (default: FOLDER/study.toml)
--name NAME  name of the study (default: the name of the folder)
--stiffness NAME=K...  stiffness of a specimen in N/mm; may be repeated
--fs HZ  sampling rate, Hz, where the files state none
--no-questions  ask nothing, even on a terminal
"""


def add_to(commands: Commands) -> None:
    parser = add_command(commands, "new", run, SUMMARY, EPILOG, OPTIONS)
    add_reading(parser)
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    from casr.atomic import write_text_atomic
    from emg2vsa.errors import SettingError
    from emg2vsa.pipeline.found_recordings import recordings_in
    from emg2vsa.study_file.draft import FILL
    from emg2vsa.study_file.drafting import look, refuse_unknown, stiffness_of, study_name

    folder, out = arguments.folder, arguments.out or arguments.folder / "study.toml"
    if not folder.is_dir():
        raise SettingError(folder, wanted="a folder of recordings", found="no folder", do="Check the path.")
    if out.exists():
        do = "Choose another name with --out, or move the file away."
        raise SettingError(out, wanted="a new file", found="an existing one", do=do)
    check_rate(arguments.fs)
    stiffness = stiffness_of(arguments.stiffness)
    found = look(folder, recordings_in([folder]), out.parent, reading_of(arguments, "new"), arguments.fs)
    refuse_unknown(stiffness, found.specimens)
    if sys.stdin.isatty() and not (arguments.no_questions or arguments.json):
        stiffness |= _asked([name for name in found.specimens if name not in stiffness])
    text = found.text(arguments.name or study_name(folder), stiffness)
    write_text_atomic(out, text)
    to_fill = [number for number, line in enumerate(text.splitlines(), 1) if FILL in line and number > 1]
    lines = [
        f"{out}: {found.named} of {len(found.files)} recordings, from {folder}",
        *(f"  {channel.name}: {channel.guess}" for channel in found.guessed),
        *(f"  not read: {one}" for one in found.unread),
        *([f"{FILL}: line{'s' if len(to_fill) > 1 else ''} {', '.join(map(str, to_fill))}"] if to_fill else []),
        f"Then: emg2vsa check {out}",
    ]
    told = {"study": str(out), "recordings": len(found.files), "fill_in_lines": to_fill, "not_read": found.unread}
    answer(arguments.json, told, lines)
    return 0


def _asked(specimens: Sequence[str]) -> dict[str, float]:
    """The stiffness of specimens as a person types it; a blank line leaves one out."""
    from emg2vsa.study_file.drafting import positive

    found = {}
    for name in specimens:
        while text := input(f"Stiffness of {name} by plate indentation, N/mm (Enter: not measured): ").strip():
            if (value := positive(text.replace(",", "."))) > 0:
                found[name] = value
                break
            print("A number above 0, please, such as 7.63")
    return found
