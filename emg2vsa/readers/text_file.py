"""A text export as bytes with numbered lines, whatever its encoding and line ends."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

from emg2vsa.errors import RecordingError

_LINE = re.compile(rb"([^\r\n]*)(\r\n|\r|\n|\Z)")


@dataclass(frozen=True)
class Line:
    """One line: its number in the file (from 1), its text, and where it begins and the next one begins in ``data``."""

    number: int
    text: str
    start: int
    end: int


@dataclass(frozen=True)
class TextFile:
    """data : the whole file as UTF-8 without byte order mark."""

    path: Path
    data: bytes

    def lines(self, start: int = 0, number: int = 1) -> Iterator[Line]:
        """Lines from byte ``start``, which is line ``number``."""
        while start < len(self.data):
            match = _LINE.match(self.data, start)
            assert match is not None
            yield Line(number, match[1].decode(), start, match.end())
            start, number = match.end(), number + 1

    def filled_lines(self, count: int, start: int = 0, number: int = 1) -> list[Line]:
        """The first ``count`` lines that are neither blank nor a ``#`` comment."""
        kept = (line for line in self.lines(start, number) if line.text.strip() and not line.text.startswith("#"))
        return list(islice(kept, count))


def open_text(path: Path) -> TextFile:
    """Read a file in UTF-8, UTF-16 with byte order mark, or else Latin-1. Raises RecordingError for binary content."""
    data = path.read_bytes().removeprefix(b"\xef\xbb\xbf")
    if data.startswith((b"\xff\xfe", b"\xfe\xff")):
        data = data.decode("utf-16", errors="replace").encode()
    elif not data.isascii():
        try:
            data.decode("utf-8")
        except UnicodeDecodeError:
            data = data.decode("latin-1").encode()
    if b"\0" in data:
        raise RecordingError(path, wanted="a text file", found="binary content", do="Export the recording as CSV.")
    return TextFile(path, data)
