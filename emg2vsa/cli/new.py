"""``emg2vsa new``: a study file drafted from a folder of recordings."""

from __future__ import annotations

import argparse
import math
import os
import re
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from casr.command_line import Commands, add_command, add_json, print_json
from emg2vsa.cli.arguments import add_reading, reading_of
from emg2vsa.cli.inspect import recordings_in

if TYPE_CHECKING:
    from emg2vsa.readers.survey import ChannelFacts, FileFacts
    from emg2vsa.settings import ReadingSettings
    from emg2vsa.study_file.draft import DraftChannel

_MUSCLES = {
    "EDC": r"edc|ext\w*[ _-]?dig\w*", "FDS": r"fds|flex\w*[ _-]?dig\w*(?![ _-]?prof)", "FDP": r"fdp",
    "FCR": r"fcr|flex\w*[ _-]?carp\w*[ _-]?rad\w*", "FCU": r"fcu|flex\w*[ _-]?carp\w*[ _-]?uln\w*",
    "ECR": r"ecr\w*|ext\w*[ _-]?carp\w*[ _-]?rad\w*", "ECU": r"ecu|ext\w*[ _-]?carp\w*[ _-]?uln\w*",
}  # fmt: skip
"""Muscles of the forearm by what channels of theirs are called."""
_MOST_EMG = 8


def add_to(commands: Commands) -> None:
    parser = add_command(
        commands,
        "new",
        run,
        "Write a first study file from a folder of recordings: people, specimens, channels, units and rates.",
        "The command guesses everything from the names and the contents of the files, and marks each guess. On a "
        "terminal it asks for what no file tells; otherwise it marks the line FILL IN. It never replaces "
        "an existing file. Example: emg2vsa new recordings --stiffness hard=6.0 --stiffness soft=1.5",
    )
    parser.add_argument("folder", type=Path, metavar="FOLDER", help="folder of recordings")
    parser.add_argument("--out", type=Path, metavar="FILE", help="study file to write (default: FOLDER/study.toml)")
    parser.add_argument("--name", metavar="NAME", help="name of the study (default: the name of the folder)")
    parser.add_argument(
        "--stiffness",
        action="append",
        default=[],
        metavar="NAME=K",
        help="stiffness of a specimen in N/mm; may be repeated",
    )
    parser.add_argument("--fs", type=float, metavar="HZ", help="sampling rate, Hz, where the files state none")
    parser.add_argument("--no-questions", action="store_true", help="ask nothing, even on a terminal")
    add_reading(parser)
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    from casr.atomic import write_text_atomic
    from emg2vsa.errors import SettingError
    from emg2vsa.study_file.draft import FILL, draft, naming_of_pairs

    folder: Path = arguments.folder
    out: Path = arguments.out or folder / "study.toml"
    if not folder.is_dir():
        raise SettingError(folder, wanted="a folder of recordings", found="no folder", do="Check the path.")
    if out.exists():
        raise SettingError(
            out,
            wanted="a new file",
            found="an existing one",
            do="Choose another name with --out, or move the file away.",
        )
    if arguments.fs is not None and not 0 < arguments.fs < math.inf:
        raise SettingError("--fs", wanted="a rate above 0 Hz", found=f"{arguments.fs:g}", do="Give the rate in hertz.")
    stiffness = _stiffness(arguments.stiffness)
    usable, unread = _usable(recordings_in([folder]), reading_of(arguments, "new"))
    if not usable:
        raise SettingError(
            folder,
            wanted="recordings",
            found="none that can be read",
            do=f"Run emg2vsa inspect {folder} for the reasons.",
        )
    files = [_relative(path, out.parent) for path in usable]
    naming, force_files = naming_of_pairs(files)
    aside = {*force_files, *(naming.left_out if naming else ())}
    named = [path for path, file in zip(usable, files, strict=True) if file not in aside]
    facts = _telling(named, reading_of(arguments, "new"), arguments.fs)
    force_facts = facts
    if force_files:
        own = [path for path, file in zip(usable, files, strict=True) if file in force_files]
        force_facts = _telling(own, reading_of(arguments, "new"), arguments.fs)
    specimens = naming.specimens if naming else ()
    _refuse_unknown(stiffness, specimens)
    ask = sys.stdin.isatty() and not (arguments.no_questions or arguments.json)
    stiffness |= _asked([name for name in specimens if name not in stiffness]) if ask else {}
    emg = {role: _drafted(channel, arguments.fs) for role, channel in _by_muscle(facts).items()}
    force = _drafted(force_facts.force, arguments.fs) if force_facts.force else None
    looked_at = dict.fromkeys(_relative(one.path, out.parent) for one in (facts, force_facts))
    seen = [*looked_at, *(f"could not be read: {one}" for one in unread)]
    name = arguments.name or re.sub(r"[^A-Za-z0-9_.-]", "", folder.resolve().name).lstrip("_.-") or "study"
    text = draft(name, naming, files, emg, force, stiffness, seen)
    write_text_atomic(out, text)
    to_fill = [number for number, line in enumerate(text.splitlines(), 1) if FILL in line and number > 1]
    if arguments.json:
        print_json({"study": str(out), "recordings": len(usable), "fill_in_lines": to_fill, "not_read": unread})
        return 0
    print(f"{out}: {len(named)} of {len(usable)} recordings, from {folder}")
    for channel in facts.emg[:_MOST_EMG] + ([force_facts.force] if force_facts.force else []):
        print(f"  {channel.name}: {channel.guess}")
    for one in unread:
        print(f"  not read: {one}")
    if to_fill:
        print(f"{FILL}: line{'s' if len(to_fill) > 1 else ''} {', '.join(map(str, to_fill))}")
    print(f"Then: emg2vsa check {out}")
    return 0


def _stiffness(given: Sequence[str]) -> dict[str, float]:
    from emg2vsa.errors import SettingError

    found: dict[str, float] = {}
    for one in given:
        name, _, text = one.partition("=")
        try:
            found[name] = float(text)
        except ValueError:
            found[name] = math.nan
        if not 0 < found[name] < math.inf:
            raise SettingError(
                "--stiffness", wanted="NAME=NUMBER in N/mm, such as S1=7.63", found=repr(one), do="Correct this option."
            )
    return found


def _refuse_unknown(stiffness: Mapping[str, float], specimens: Sequence[str]) -> None:
    from emg2vsa.errors import SettingError

    for name in stiffness:
        if name not in specimens:
            raise SettingError(
                "--stiffness", wanted=f"a specimen that the files name ({', '.join(specimens) or 'none was found'})",
                found=repr(name), do="Correct it, or write it into the study file.",
            )  # fmt: skip


def _asked(specimens: Sequence[str]) -> dict[str, float]:
    """The stiffness of specimens as a person types it; a blank line leaves one out."""
    found = {}
    for name in specimens:
        while text := input(f"Stiffness of {name} by plate indentation, N/mm (Enter: not measured): ").strip():
            try:
                value = float(text.replace(",", "."))
            except ValueError:
                value = math.nan
            if 0 < value < math.inf:
                found[name] = value
                break
            print("A number above 0, please, such as 7.63")
    return found


def _usable(paths: Sequence[Path], reading: ReadingSettings) -> tuple[list[Path], list[str]]:
    """Those that open with channels, and what is wrong with each of the others."""
    from emg2vsa.errors import RecordingError
    from emg2vsa.readers.front_door import open_recording

    usable, unread = [], []
    for path in paths:
        try:
            _, opened = open_recording(path, reading)
            if opened.contents.names:
                usable.append(path)
        except RecordingError as error:
            unread.append(f"{path.name}, {error.found}")
    return usable, unread


def _telling(paths: Sequence[Path], reading: ReadingSettings, fs_hz: float | None) -> FileFacts:
    """The first file in which EMG and force are found; else the first with either; else the first."""
    from emg2vsa.readers.survey import survey

    best: FileFacts | None = None
    for path in paths[:10]:
        facts = survey(path, reading, fs_hz)
        if facts.emg and facts.force:
            return facts
        if best is None or (facts.emg and not best.emg):
            best = facts
    assert best is not None
    return best


def _by_muscle(facts: FileFacts) -> dict[str, ChannelFacts]:
    """EMG channels by muscle where their names tell it, all of them by name where none does."""
    found: dict[str, ChannelFacts] = {}
    for channel in facts.emg:
        for role, names in _MUSCLES.items():
            if re.search(rf"(^|[^a-z])({names})([^a-z]|$)", channel.name, re.IGNORECASE):
                found.setdefault(role, channel)
    return found or {channel.name: channel for channel in facts.emg[:_MOST_EMG]}


def _drafted(channel: ChannelFacts, fs_hz: float | None) -> DraftChannel:
    from emg2vsa.study_file.draft import DraftChannel

    return DraftChannel(channel.name, channel.unit, fs_hz, channel.sign, channel.guess, not channel.fs_hz > 0)


def _relative(path: Path, folder: Path) -> str:
    return Path(os.path.relpath(path, folder)).as_posix()
