"""Names of files in letters that ids may have, so that no two names become one."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence

from emg2vsa.study_file.patterns import PLACEHOLDER, Cell

_IN_ASCII = str.maketrans({
    "ß": "ss", "ø": "oe", "Ø": "Oe", "æ": "ae", "Æ": "Ae", "å": "aa", "Å": "Aa", "ł": "l", "Ł": "L", "đ": "d",
    "Đ": "D", "ı": "i",
})  # fmt: skip
_UMLAUT = re.compile("([aouAOU])\u0308")
_SEPARATORS = re.compile(r"([/_ -]+)")


def plain_parts(files: Iterable[str]) -> dict[str, str]:
    """Each part of the paths between ``/ _ -`` and blanks, less the extension, as an id may be written.

    A name in letters that have none in ASCII gets a number, such as x1.
    """
    parts = dict.fromkeys(part for file in files for part in _SEPARATORS.split(_stem(file))[::2])
    written: dict[str, str] = {}
    taken: set[str] = set()
    for part in sorted(parts, key=lambda part: in_ascii(part) != part):  # who needs no change keeps the own name
        text = in_ascii(part)
        written[part] = _free(text, taken) if text or not part else _free("x1", taken, lambda n: f"x{n}")
        taken.add(written[part].casefold())
    return written


def plain_path(file: str, written: Mapping[str, str]) -> str:
    stem = _stem(file)
    parts = _SEPARATORS.split(stem)
    parts[::2] = [written[part] for part in parts[::2]]
    return "".join(parts) + file[len(stem) :]


def numbered(names: Sequence[str], tokens: Collection[str], letter: str) -> dict[str, str]:
    """Names that are numbers of ``plain_parts`` as P01 or S01; the others as they are."""
    found = {name: name for name in names if name not in tokens}
    taken = {name.casefold() for name in found}
    for name in names:
        if name in tokens:
            found[name] = _free(f"{letter}01", taken, lambda n: f"{letter}{n:02d}")
            taken.add(found[name].casefold())
    return found


def cell_of(file: str, pattern: str, people: Sequence[str], specimens: Sequence[str]) -> tuple[Cell, int] | None:
    """Participant, specimen and repetition of a file as a pattern has them; None where it is named otherwise."""
    choices = {"{participant}": people, "{specimen}": specimens}
    expression, seen = "", set()
    for text in PLACEHOLDER.split(pattern):
        key = text.strip("{}")
        if not PLACEHOLDER.fullmatch(text):
            expression += re.escape(text)
        elif text == "*":
            expression += "[^/]*"
        elif text in seen:
            expression += f"(?P={key})"
        else:
            names = sorted(choices.get(text, ()), key=len, reverse=True)
            expression += f"(?P<{key}>{'|'.join(map(re.escape, names)) or '[0-9]+'})"
        seen.add(text)
    match = re.fullmatch(expression, file)
    if match is None:
        return None
    told = match.groupdict()
    cell = (told.get("participant", people[0]), told.get("specimen", specimens[0]))
    return cell, int(told.get("repetition", 0))


def _stem(file: str) -> str:
    stem, dot, _ = file.rpartition(".")
    return stem if dot else file


def in_ascii(text: str) -> str:
    """The text in ASCII letters, digits, dots and hyphens; "" where a letter of it has none."""
    text = unicodedata.normalize("NFC", text).translate(_IN_ASCII)
    text = _UMLAUT.sub(r"\1e", unicodedata.normalize("NFKD", text))
    text = "".join(c for c in text if not unicodedata.combining(c))
    if any(c.isalnum() and not c.isascii() for c in text):
        return ""
    return re.sub(r"[^A-Za-z0-9.-]", "", text).lstrip(".-")


def _free(text: str, taken: Collection[str], number: Callable[[int], str] | None = None) -> str:
    """The text, or the first numbered one that nobody has."""
    n = 1
    while text.casefold() in taken:
        n += 1
        text = number(n) if number else f"{text.rpartition('-')[0] if n > 2 else text}-{n}"
    return text
