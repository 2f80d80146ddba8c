"""What no file tells, asked of a person: every question says what was guessed and why, and an empty answer takes it."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Protocol, TypeVar

from emg2vsa.readers.survey import ChannelFacts
from emg2vsa.study_file.draft import Naming, naming_of_pairs
from emg2vsa.study_file.draft_channel import DraftChannel
from emg2vsa.study_file.drafting import MUSCLES, Found, positive

_T = TypeVar("_T")
_FORCES = ("N", "mN", "kN", "kgf", "gf", "lbf")
_VOLTS = ("V", "mV", "uV")
_WEIGHTS = {"g": "gf", "kg": "kgf", "lb": "lbf"}
"""What a scale shows, and the force that is meant."""
_YES, _NO = ("yes", "y", "ja", "j"), ("no", "n", "nein")


class Ask(Protocol):
    """Puts a question and returns the answer."""

    def __call__(self, question: str, guess: str, parse: Callable[[str], _T], wanted: str) -> _T:
        """The answer as ``parse`` makes it of what was typed, of ``guess`` where that is nothing.

        question : may have several lines. parse : ValueError for an answer that is not what is ``wanted``.
        """


def ask_about(found: Found, stiffness: Mapping[str, float], ask: Ask) -> tuple[Found, dict[str, float], int | None]:
    """What was found as a person corrects it, the stiffness of specimens in N/mm, and the presses on each, if planned.

    stiffness : of specimens that need no question.
    """
    found = _ask_names(found, ask)
    found = _ask_force(found, ask)
    found = _ask_muscles(found, ask)
    emg, force = found.emg_channels, found.force_channel
    if told := [channel for channel in emg.values() if channel.is_unit_guessed]:
        unit = ask(
            f"{_names(told)}: {told[0].unit_doubt}.\nThe unit: V, mV or uV?", told[0].guessed_unit, _one_of(_VOLTS),
            "V, mV or uV",
        )  # fmt: skip
        emg = {role: replace(c, told_unit=unit) if c.is_unit_guessed else c for role, c in emg.items()}
    if untimed := [channel for channel in emg.values() if channel.no_rate]:
        rate_hz = _ask_rate(untimed, ask)
        emg = {role: replace(c, fs_hz=rate_hz, no_rate=False) if c.no_rate else c for role, c in emg.items()}
    if force is not None:
        force = _ask_about_force(force, ask)
    known = dict(stiffness)
    for name in found.specimens:
        if name not in known and (value := _ask_stiffness(name, ask)) is not None:
            known[name] = value
    question = "How often did each participant press each specimen? (Enter: it was not planned)"
    presses = ask(question, "", lambda text: _whole(text) if text else None, "a whole number above 0, such as 10")
    return replace(found, emg_channels=emg, force_channel=force), known, presses


def _ask_names(found: Found, ask: Ask) -> Found:
    """Which part of the names tells what was pressed, where two parts may."""
    naming = found.naming
    if naming is None or not all(f"{{{role}}}" in naming.pattern for role in ("participant", "specimen")):
        return found
    question = (
        f"The files are named {naming.pattern}.\n  who pressed: {_some(naming.participants)}\n  what was pressed: "
    )
    question += f"{_some(naming.specimens)}\nIs it so? If not, type one name of what was pressed."

    def parse(text: str) -> Naming:
        if text in naming.specimens:
            return naming
        other, _ = naming_of_pairs(found.files, [text])
        if other is None or text not in other.specimens:
            raise ValueError
        return other

    def is_so(text: str) -> Naming | None:
        is_part = any(text in re.split(r"[^A-Za-z0-9]", file) for file in found.files)  # somebody may be called n
        if text.lower() in _YES and not is_part:
            return naming
        return None if text.lower() in _NO and not is_part else parse(text)

    told = ask(question, "yes", is_so, "yes, or a part of the files' names")
    if told is None:
        question = f"Then what was pressed? Type one part of {found.files[0]} or of another name that tells it."
        told = ask(question, "", parse, "a part of the files' names")
    return replace(found, naming=told)


def _ask_force(found: Found, ask: Ask) -> Found:
    """Which channel the force is, where several may be it or none looks like it."""
    facts = found.force
    fit = [c for c in facts.channels if c.role == "force" or (c.role == "other" and c.fs_hz > 0 and c.noise >= 0)]
    likely = [c for c in fit if c.role == "force" or c.may_press]
    shown = likely if facts.force and len(likely) > 1 else fit
    if (len(shown) < 2 and facts.force) or not shown:
        return found
    guess = facts.force or shown[0]
    question = f"{_listed(shown)}\nWhich of them is the force that presses? Its number or name."
    chosen = ask(question, guess.name, _channel_of(shown), f"a number from 1 to {len(shown)}, or a name")
    return replace(found, force_channel=found.drafted(chosen))


def _ask_muscles(found: Found, ask: Ask) -> Found:
    """Which muscle each EMG channel is, where the names of some do not tell."""
    channels = found.emg_channels
    used = [channel.name for channel in channels.values()]
    more = [found.drafted(channel) for channel in found.emg.emg if channel.name not in used]
    if channels.keys() <= MUSCLES.keys() and not more:
        return found
    shown = [*channels.values(), *more]
    names = [channel.name for channel in shown]
    listed = "\n".join(f"  {number} {c.name}: {c.said}" for number, c in enumerate(shown, 1))
    all_used = f"only {', '.join(used)} are used" if more else "all are used"
    question = f"{listed}\nWhich muscles are they? Such as 1=FDS 2=EDC; the others are left out. (Enter: {all_used})"

    def parse(text: str) -> dict[str, DraftChannel]:
        if not text:
            return dict(channels)
        pairs = [re.fullmatch(r"(.+)=(\w+)", word) for word in re.split(r"[\s,;]+", text)]
        told = {pair[2]: shown[names.index(_by_number(pair[1], names))] for pair in pairs if pair}
        if None in pairs or len({channel.name for channel in told.values()}) < len(pairs):
            raise ValueError
        return told

    told = ask(question, "", parse, "pairs such as 1=FDS 2=EDC")
    return replace(found, emg_channels=told, left_out=found.left_out if told == channels else ())


def _ask_about_force(force: DraftChannel, ask: Ask) -> DraftChannel:
    if force.is_unit_guessed:
        question = f"{force.name}: {force.unit_doubt}.\nThe unit: {', '.join(_FORCES)}, or how many newtons one is?"
        unit = ask(question, force.guessed_unit, _force_unit, f"{', '.join(_FORCES)} or a number above 0, such as 0.02")
        force = replace(force, told_unit=unit)
    if force.no_rate:
        force = replace(force, fs_hz=_ask_rate([force], ask), no_rate=False)
    question = f"{force.name}: {force.said or 'nothing tells which way it goes'}.\nDoes pressing raise or lower it?"
    rises = ask(question, "lowers" if force.sign < 0 else "raises", _either("raises", "lowers"), "raises or lowers")
    return replace(force, sign=1 if rises else -1)


def _ask_rate(channels: Sequence[DraftChannel], ask: Ask) -> float:
    question = f"{_names(channels)}: the file has no time column.\nHow many samples are there in a second?"
    return ask(question, "1000", _number, "a number above 0, such as 1000")


def _ask_stiffness(specimen: str, ask: Ask) -> float | None:
    question = f"Stiffness of {specimen} by plate indentation, in N/mm? (Enter: it was not measured)"
    return ask(question, "", lambda text: _number(text) if text else None, "a number above 0, such as 7.63")


def _listed(channels: Sequence[ChannelFacts]) -> str:
    return "\n".join(f"  {number} {c.name}: {c.guess}" for number, c in enumerate(channels, 1))


def _names(channels: Sequence[DraftChannel]) -> str:
    return _some([channel.name for channel in channels])


def _some(names: Sequence[str]) -> str:
    return ", ".join(names[:6]) + (f" and {len(names) - 6} more" if len(names) > 6 else "")


def _channel_of(channels: Sequence[ChannelFacts]) -> Callable[[str], ChannelFacts]:
    by_name = {channel.name: channel for channel in channels}
    return lambda text: by_name[_by_number(text, list(by_name))]


def _by_number(text: str, names: Sequence[str]) -> str:
    """The name that ``text`` is or counts. ValueError for none."""
    if text in names:
        return text
    number = _whole(text)
    if number > len(names):
        raise ValueError
    return names[number - 1]


def _whole(text: str) -> int:
    number = int(text)
    if number < 1:
        raise ValueError
    return number


def _number(text: str) -> float:
    value = positive(text.replace(",", "."))
    if not value > 0:
        raise ValueError
    return value


def _one_of(words: Sequence[str]) -> Callable[[str], str]:
    def parse(text: str) -> str:
        text = re.sub("^[µμ]", "u", text)  # the sign of micro, and the Greek letter
        if text not in words:
            raise ValueError
        return text

    return parse


def _either(yes: str, no: str) -> Callable[[str], bool]:
    """Whether the answer is ``yes``, of which a beginning is enough, or ``no``."""

    def parse(text: str) -> bool:
        answers = [word for word in (yes, no) if word.startswith(text.lower())]
        if len(answers) != 1:
            raise ValueError
        return answers[0] == yes

    return parse


def _force_unit(text: str) -> str:
    text = _WEIGHTS.get(text, text)
    return text if text in _FORCES else f"{_number(text):g}"
