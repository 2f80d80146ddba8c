"""A text export as bytes with numbered lines, whatever its encoding and line ends; separator and decimal sign are
sniffed from its own lines and never assumed."""

from __future__ import annotations

import csv
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

from emg2vsa.errors import RecordingError

_COMMA = re.compile(r"[+-]?\d*,\d+([eE][+-]?\d+)?")
_POINT = re.compile(r"[+-]?\d*\.\d+([eE][+-]?\d+)?")
_LOOKS, _LONGEST_LOOK = 200, 2000
"""How often, and at how many bytes, the rest of a file is looked at where its first rows leave a doubt."""
WHITESPACE = r"\s+"
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
    elif (wide := unmarked_utf16(data[:4096])) is not None:
        data = data.decode(wide, errors="replace").encode()
    elif not data.isascii():
        try:
            data.decode("utf-8")
        except UnicodeDecodeError:
            data = data.decode("latin-1").encode()
    if b"\0" in data:
        raise RecordingError(path, wanted="a text file", found="binary content", do="Export the recording as CSV.")
    return TextFile(path, data)


def unmarked_utf16(head: bytes) -> str | None:
    """The byte order of UTF-16 without a mark: nearly every second byte of Western text is zero, the others none."""
    pairs = len(head) // 2
    even, odd = head[0 : 2 * pairs : 2].count(0), head[1 : 2 * pairs : 2].count(0)
    if pairs < 8 or min(even, odd):
        return None
    return "utf-16-le" if odd > 0.9 * pairs else "utf-16-be" if even > 0.9 * pairs else None


def without_cut_line(text: TextFile) -> tuple[TextFile, tuple[str, ...]]:
    """The file without a last line that has no line end, and a note on it: it may be cut in the middle of a number."""
    if not text.data or text.data.endswith((b"\n", b"\r")):
        return text, ()
    kept = max(text.data.rfind(b"\n"), text.data.rfind(b"\r")) + 1
    if not text.data[:kept].strip() or not text.data[kept:].strip():  # a file of one line holds no recording
        return text, ()
    number = len(text.data[:kept].splitlines()) + 1
    note = f"Line {number}, the last, has no line end and may be cut in the middle of a number; it was left out."
    return TextFile(text.path, text.data[:kept]), (note,)


@dataclass(frozen=True)
class Dialect:
    """separator : "," ";" tab or WHITESPACE. decimal : "." or ","."""

    separator: str
    decimal: str

    def split(self, line: str) -> list[str]:
        """Cells of a line, unquoted and stripped."""
        if self.separator == WHITESPACE:
            return line.split()
        return [cell.strip() for cell in next(csv.reader([line], delimiter=self.separator, skipinitialspace=True), [])]

    @property
    def note(self) -> str:
        return "" if self.decimal == "." else "Numbers are written with a decimal comma."


def sniff(path: Path, header: Line | None, rows: Sequence[Line], body: bytes) -> Dialect:
    """The dialect in which header and rows agree.

    rows : the first data lines. body : all data, searched for a decimal comma where those rows hold whole numbers only.

    Raises RecordingError where decimal points and decimal commas are mixed, and where a sign may group thousands.
    """
    separator = separator_of(header, rows)
    plain = Dialect(separator, ".")
    cells = [cell for row in rows for cell in plain.split(row.text)]
    commas, points = any(map(_COMMA.fullmatch, cells)), any(map(_POINT.fullmatch, cells))
    if commas and points:
        raise RecordingError(
            f"{path}, from line {rows[0].number}", wanted="one decimal sign", found="decimal points and decimal commas",
            do="Export the numbers without thousands separators and with one decimal sign.",
        )  # fmt: skip
    if not commas and not points and separator != ",":
        commas = b"," in body and b"." not in body
    dialect = Dialect(separator, "," if commas else ".")
    _refuse_grouped(path, dialect, rows, body)
    return dialect


def _refuse_grouped(path: Path, dialect: Dialect, rows: Sequence[Line], body: bytes) -> None:
    """Whole numbers below a thousand beside "1.234" and the like only: whether 1234 is meant cannot be known."""
    table = [dialect.split(row.text) for row in rows]
    suspects = [i for i in range(len(table[0])) if _grouped([row[i] for row in table if i < len(row)], dialect)]
    if not suspects:
        return
    parts = [body[at : at + _LONGEST_LOOK] for at in range(0, len(body), max(len(body) // _LOOKS, _LONGEST_LOOK))]
    lines = [line for part in parts for line in re.split(rb"[\r\n]+", part)[1:-1]]
    table += [dialect.split(line.decode(errors="replace")) for line in lines]
    for i in suspects:
        cells = [row[i] for row in table if i < len(row)]
        example = next((cell for cell in cells if dialect.decimal in cell), None)
        if example is not None and _grouped(cells, dialect):
            raise RecordingError(
                f"{path}, column {i + 1}", wanted="numbers of one meaning",
                found=f"{example!r} among whole numbers, which may be {example.replace(dialect.decimal, '')} or a "
                "fraction", do="Export without thousands separators, or all numbers with the same number of decimals.",
            )  # fmt: skip


def _grouped(cells: Sequence[str], dialect: Dialect) -> bool:
    """Whether all are whole numbers below 1000 or look like grouped thousands, with whole ones among them."""
    sign = re.escape(dialect.decimal)
    kind = [re.fullmatch(rf"[+-]?(?:(\d{{1,3}})|[1-9]\d{{0,2}}(?:{sign}\d{{3}})+)", cell) for cell in cells if cell]
    return all(kind) and any(match[1] is not None for match in kind if match)


def separator_of(header: Line | None, rows: Sequence[Line]) -> str:
    """The first of ; tab , that splits every line into two cells or more; else whitespace or a single column."""
    lines = [line.text for line in ([header] if header else []) + list(rows)]
    for candidate in (";", "\t", ","):
        if all(len(Dialect(candidate, ".").split(line)) > 1 for line in lines):
            return candidate
    if all(len(line.split()) > 1 for line in lines):
        return WHITESPACE
    return next((c for c in (";", "\t", ",") if any(c in line for line in lines)), ",")
