"""What the recordings of a folder tell a study file: names, channels and rates of those that tell most."""

from __future__ import annotations

import hashlib
import math
import os
import re
from collections import Counter
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from emg2vsa.errors import RecordingError, SettingError
from emg2vsa.readers.front_door import open_recording
from emg2vsa.readers.survey import ChannelFacts, FileFacts, force_by_file, survey
from emg2vsa.settings import ReadingSettings
from emg2vsa.study_file.draft import (
    Naming,
    doubtful,
    draft,
    halves,
    naming_of_kinds,
    naming_of_pairs,
    people_and_specimens,
)
from emg2vsa.study_file.draft_channel import DraftChannel

MUSCLES = {
    "EDC": r"edc|ext\w*[ _-]?dig\w*", "FDS": r"fds|flex\w*[ _-]?dig\w*(?![ _-]?prof)", "FDP": r"fdp",
    "FCR": r"fcr|flex\w*[ _-]?carp\w*[ _-]?rad\w*", "FCU": r"fcu|flex\w*[ _-]?carp\w*[ _-]?uln\w*",
    "ECR": r"ecr\w*|ext\w*[ _-]?carp\w*[ _-]?rad\w*", "ECU": r"ecu|ext\w*[ _-]?carp\w*[ _-]?uln\w*",
}  # fmt: skip
"""Muscles of the forearm by what channels of theirs are called."""
MOST_EMG, _MOST_READ = 8, 10


@dataclass(frozen=True, eq=False)
class Found:
    """What a folder holds.

    files : recordings that can be read, relative to their folder. unread : what is wrong with each of the others.
    named : how many fit the naming. emg, force : channels of the file that tells most, and of that of the force.
    fs_hz : rate of channels whose file states none. emg_channels, force_channel : to be used, the former by muscle.
    left_out : channels that may be EMG and are not used, and why, a sentence each. base : the folder of the files from
    the study file, "" or with "/" at its end. copies : files that are others byte by byte, a sentence each.
    """

    files: tuple[str, ...]
    unread: tuple[str, ...]
    naming: Naming | None
    named: int
    emg: FileFacts
    force: FileFacts
    looked_at: tuple[str, ...]
    fs_hz: float | None
    emg_channels: Mapping[str, DraftChannel] = field(default_factory=dict)
    force_channel: DraftChannel | None = None
    left_out: tuple[str, ...] = ()
    base: str = ""
    copies: tuple[str, ...] = ()

    @property
    def specimens(self) -> tuple[str, ...]:
        """As the names of the files have them."""
        return people_and_specimens(self.naming, self.files)[1]

    @property
    def told(self) -> list[str]:
        """Who pressed what, and what else a person should look at, a line each."""
        people, specimens = people_and_specimens(self.naming, self.files)
        lines = [f"who pressed: {', '.join(people)}", f"what was pressed: {', '.join(specimens)}"]
        lines += self.naming.guessed if self.naming else []
        lines += [*doubtful((*people, *specimens)), *self.copies, *(f"left out: {one}" for one in self.left_out)]
        return [*lines, *([self.force_channel.rival] if self.force_channel and self.force_channel.rivals else [])]

    @property
    def hints(self) -> list[str]:
        """What would tell more of the channels."""
        return list(dict.fromkeys(filter(None, (self.emg.hint, self.force.hint))))

    def text(self, name: str, stiffness: Mapping[str, float], presses: int | None = None) -> str:
        """The study file. stiffness : of specimens, N/mm. presses : of each participant on each of them, if planned."""
        seen = [*self.looked_at, *self.hints, *(f"could not be read: {one}" for one in self.unread)]
        return draft(
            name, self.naming, self.files, self.emg_channels, self.force_channel, stiffness, seen, presses,
            self.left_out, self.base, self.copies,
        )  # fmt: skip

    @property
    def needs_no_rate(self) -> bool:
        """Whether a rate was given, and the files state that of every channel."""
        used = [*self.emg_channels.values(), *([self.force_channel] if self.force_channel else [])]
        return self.fs_hz is not None and all(channel.fs_hz is None for channel in used)

    def rate_hz(self, channel: DraftChannel) -> float:
        """Rate of a channel, Hz, as the files tell it; NaN where they do not."""
        facts = self.force if channel.is_force else self.emg
        return next((each.fs_hz for each in facts.channels if each.name == channel.name), math.nan)

    def drafted(self, channel: ChannelFacts) -> DraftChannel:
        """A channel of the files as the study file is to have it."""
        is_force = channel.role != "EMG"
        fs_hz = self.fs_hz if channel.name in (self.force if is_force else self.emg).untimed else None
        return DraftChannel(
            channel.name, channel.unit, fs_hz, channel.sign, channel.guess, not channel.fs_hz > 0, is_force,
            max(abs(channel.low), abs(channel.high)),
        )  # fmt: skip


def look(
    folder: Path, paths: Sequence[Path], beside: Path, reading: ReadingSettings, fs_hz: float | None,
    pressed: Collection[str] = (),
) -> Found:  # fmt: skip
    """Open the recordings ``paths`` of ``folder``, for a study file in ``beside``.

    fs_hz : rate of channels whose file states none, Hz. pressed : names of specimens that are known.
    SettingError: none of the files can be read, or one holds everything.
    """
    usable, unread = _usable(paths, reading)
    if not usable:
        do = f"Run emg2vsa inspect {folder} for the reasons."
        raise SettingError(folder, wanted="recordings", found="none that can be read", do=do)
    by_file = {_relative(path, folder): path for path in usable}
    base = _relative(folder, beside)
    naming, force_files = naming_of_pairs(list(by_file), pressed)
    if not force_files and (pairs := _pairs_by_content(by_file, reading, fs_hz, pressed)) is not None:
        naming, force_files = pairs
    aside = {*force_files, *(naming.left_out if naming else ())}
    named = [path for file, path in by_file.items() if file not in aside]
    emg = force = _telling(named, reading, fs_hz)
    _refuse_one_table(emg)
    if force_files:
        force = force_by_file(_telling([path for file, path in by_file.items() if file in force_files], reading, fs_hz))
    looked_at = dict.fromkeys(_relative(one.path, beside) for one in (emg, force))
    found = Found(
        tuple(by_file), tuple(unread), naming, len(named), emg, force, tuple(looked_at), fs_hz,
        base="" if base == "." else f"{base}/", copies=tuple(_copies(by_file)),
    )  # fmt: skip
    used, left_out = _by_muscle(emg)
    channels = {role: found.drafted(channel) for role, channel in used.items()}
    # one amplifier has one unit
    largest = max((channel.largest for channel in channels.values() if channel.is_unit_guessed), default=math.nan)
    channels = {role: replace(channel, largest=largest) for role, channel in channels.items()}
    pressing = found.drafted(force.force) if force.force else None
    if pressing is not None:
        pressing = replace(pressing, rivals=tuple(channel.name for channel in force.rivals))
    return replace(found, emg_channels=channels, force_channel=pressing, left_out=tuple(left_out))


def _copies(by_file: Mapping[str, Path]) -> Iterator[str]:
    """A sentence for each file that is an earlier one byte by byte; only files of one size are read."""
    sizes = Counter(path.stat().st_size for path in by_file.values())
    first: dict[bytes, str] = {}
    for file, path in sorted(by_file.items(), key=lambda item: len(item[0])):  # copies have the longer names
        if sizes[path.stat().st_size] > 1:
            with path.open("rb") as stream:
                other = first.setdefault(hashlib.file_digest(stream, "sha256").digest(), file)
            if other != file:
                yield f"{file} is {other} byte by byte; take one of them out of the folder"


def _refuse_one_table(facts: FileFacts) -> None:
    """SettingError for a table of all people and objects: columns of words, and times that begin again and again."""
    words = [channel.name for channel in facts.channels if channel.fault.startswith("found '")]
    if words and all(channel.fault for channel in facts.channels):
        found = f"one with words in {', '.join(words)}, whose other columns are no channels"
        do = "Save one file for each of their values, such as P01_soft.csv."
        raise SettingError(facts.path, wanted="a recording of one person on one object", found=found, do=do)


def _pairs_by_content(
    by_file: Mapping[str, Path], reading: ReadingSettings, fs_hz: float | None, pressed: Collection[str]
) -> tuple[Naming, list[str]] | None:
    """The naming where one half of the files holds EMG and the other a force, and the latter."""
    for parted in halves(list(by_file)):
        facts = [survey(by_file[files[0]], reading, fs_hz) for files in parted]
        kinds = [(bool(each.emg), force_by_file(each).force is not None) for each in facts]
        if kinds not in ([(True, False), (False, True)], [(False, True), (True, False)]):
            continue
        emg, force = parted if kinds[0][0] else parted[::-1]
        naming = naming_of_kinds(list(by_file), emg, force, pressed)
        if naming is not None:
            return naming, [file for file in force if file not in naming.left_out]
    return None


def study_name(folder: Path) -> str:
    """The name of a study after that of its folder."""
    return re.sub(r"[^A-Za-z0-9_.-]", "", folder.resolve().name).lstrip("_.-") or "study"


def stiffness_of(given: Sequence[str]) -> dict[str, float]:
    """Specimen to N/mm from texts such as S1=7.63. SettingError for another text."""
    found: dict[str, float] = {}
    for one in given:
        name, _, text = one.partition("=")
        if name in found:
            do = "Give one stiffness for each specimen."
            raise SettingError("--stiffness", wanted="each specimen once", found=f"{name!r} twice", do=do)
        found[name] = positive(text)
        if math.isnan(found[name]):
            wanted = "NAME=NUMBER in N/mm, such as S1=7.63"
            raise SettingError("--stiffness", wanted=wanted, found=repr(one), do="Correct this option.")
    return found


def by_specimen(stiffness: Mapping[str, float], specimens: Sequence[str]) -> dict[str, float]:
    """The stiffness of specimens as the files name them; the end of one name is enough: A for objectA.

    SettingError for a specimen that no file names, or several do.
    """
    found = {}
    for name, value in stiffness.items():
        meant = [name] if name in specimens else [each for each in specimens if each.lower().endswith(name.lower())]
        if len(meant) != 1:
            wanted = f"a specimen that the files name ({', '.join(specimens) or 'none was found'})"
            do = "Correct it, or write it into the study file."
            raise SettingError("--stiffness", wanted=wanted, found=repr(name), do=do)
        found[meant[0]] = value
    return found


def positive(text: str) -> float:
    """The number above 0 that the text is; NaN where it is none."""
    try:
        value = float(text)
    except ValueError:
        return math.nan
    return value if 0 < value < math.inf else math.nan


def _usable(paths: Sequence[Path], reading: ReadingSettings) -> tuple[list[Path], list[str]]:
    """Those that open with channels, and what is wrong with each of the others."""
    usable, unread = [], []
    for path in paths:
        try:
            os.fspath(path).encode()  # a study file is text
        except UnicodeEncodeError:
            name = os.fsencode(path.name).decode(errors="backslashreplace")
            unread.append(f"{name}, a path that is not in UTF-8: rename it")
            continue
        try:
            _, opened = open_recording(path, reading)
            if opened.contents.names:
                usable.append(path)
        except RecordingError as error:
            unread.append(f"{path.name}, {error.found}")
    return usable, unread


def _telling(paths: Sequence[Path], reading: ReadingSettings, fs_hz: float | None) -> FileFacts:
    """The first file in which EMG and force are found; else the first with either; else the first."""
    best: FileFacts | None = None
    for path in paths[:_MOST_READ]:
        facts = survey(path, reading, fs_hz)
        if facts.emg and facts.force:
            return facts
        if best is None or (facts.emg and not best.emg):
            best = facts
    assert best is not None
    return best


def _by_muscle(facts: FileFacts) -> tuple[dict[str, ChannelFacts], list[str]]:
    """EMG channels by muscle where their names tell it, else by name; and those that are left out, and why."""
    muscles = {channel.name: _muscle(channel.name) for channel in facts.emg}
    found: dict[str, ChannelFacts] = {}
    more, left_out = [], []
    for channel in sorted(facts.emg, key=lambda channel: not muscles[channel.name]):
        role = muscles[channel.name] or channel.name
        if role in found:
            left_out.append(f"{channel.name}, looks like EMG of {role} as {found[role].name} does")
        elif len(found) < MOST_EMG:
            found[role] = channel
        else:
            more.append(channel.name)
    if more:
        what = f"{len(more)} channels that look like EMG" if len(more) > 1 else "a channel that looks like EMG"
        left_out.append(f"{what}, as a draft takes {MOST_EMG}: {', '.join(more)}")
    return found, [*left_out, *(f"{channel.name} ({channel.guess or channel.fault})" for channel in facts.lost)]


def _muscle(name: str) -> str:
    """The muscle that a channel is called after, or ""."""
    signs = ((role, rf"(^|[^a-z])({names})([^a-z]|$)") for role, names in MUSCLES.items())
    return next((role for role, sign in signs if re.search(sign, name, re.IGNORECASE)), "")


def _relative(path: Path, folder: Path) -> str:
    return Path(os.path.relpath(path, folder)).as_posix()
