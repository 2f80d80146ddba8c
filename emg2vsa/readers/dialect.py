"""Separator and decimal sign of a text table, sniffed from its own lines and never assumed."""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from emg2vsa.errors import RecordingError
from emg2vsa.readers.text_file import Line

_COMMA = re.compile(r"[+-]?\d*,\d+([eE][+-]?\d+)?")
_POINT = re.compile(r"[+-]?\d*\.\d+([eE][+-]?\d+)?")
WHITESPACE = r"\s+"


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

    Raises RecordingError where decimal points and decimal commas are mixed.
    """
    separator = _separator(header, rows)
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
    return Dialect(separator, "," if commas else ".")


def _separator(header: Line | None, rows: Sequence[Line]) -> str:
    """The first of ; tab , that splits every line into two cells or more; else whitespace or a single column."""
    lines = [line.text for line in ([header] if header else []) + list(rows)]
    for candidate in (";", "\t", ","):
        if all(len(Dialect(candidate, ".").split(line)) > 1 for line in lines):
            return candidate
    if all(len(line.split()) > 1 for line in lines):
        return WHITESPACE
    return next((c for c in (";", "\t", ",") if any(c in line for line in lines)), ",")
