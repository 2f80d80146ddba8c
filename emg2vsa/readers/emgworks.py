"""CSV exports of Delsys EMGworks 4, bare and verbose.

Bare: a header ``X[s],"Avanti sensor 1: EMG 1",X[s],...`` where every channel has its own time column, written with
seven significant digits; EMG in V, which the header does not say. Verbose: the same below lines ``Label: ...
Sampling frequency: ... Number of points: ... start: ... Unit: ... Domain Unit: s``. Slower channels end early: blank
cells, or in some exports zeros.
"""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

from emg2vsa.errors import RecordingError
from emg2vsa.readers.cells import Body
from emg2vsa.readers.opened import Contents, unique_names
from emg2vsa.readers.plain_csv import checked_width, header_and_rows, widest
from emg2vsa.readers.text_file import TextFile, open_text, sniff, without_cut_line
from emg2vsa.readers.timed_columns import Column, TimedColumns
from emg2vsa.readers.units import canonical, split_unit

_TIME_DIGITS = 7
_LABEL = re.compile(
    r"Label:\s*(?P<label>.*?)\s+Sampling frequency:\s*(?P<fs>\S+)\s+Number of points:\s*(?P<n>\d+)\s+"
    r"start:\s*(?P<start>\S+)\s+Unit:\s*(?P<unit>.*?)\s+Domain Unit:\s*(?P<domain>\S*)\s*"
)


def open_recording(path: Path) -> TimedColumns:
    """Validate the header lines. Raises RecordingError; cells are checked when they are read."""
    text, cut = without_cut_line(open_text(path))
    stated, start, number = _stated(text)
    header, rows = header_and_rows(text, start, number)
    body_data = text.data[header.end :]
    dialect = sniff(path, header, rows, body_data)
    labels = dialect.split(header.text)
    allowed = checked_width(path, dialect, labels, rows)
    channels = _pairs(path, header.number, labels)
    if stated:
        channels = _with_statements(path, channels, stated)
    names = unique_names([column.name for column in channels])
    columns = tuple(replace(column, name=name) for column, name in zip(channels, names, strict=True))
    contents = Contents(names, {}, (*cut, *filter(None, [dialect.note])))
    body = Body(path, body_data, header.number + 1, dialect, widest(dialect, rows), allowed)
    return TimedColumns(path, contents, body, columns)


def _stated(text: TextFile) -> tuple[list[tuple[str, Column]], int, int]:
    """The ``Label:`` lines as (label, what it states), and where the header row begins (byte, line number)."""
    stated: list[tuple[str, Column]] = []
    for line in text.lines():
        if re.match(r'"?X\s*\[', line.text):
            return stated, line.start, line.number
        if line.text.startswith("Label:"):
            stated.append(_statement(text.path, line.number, line.text))
    raise RecordingError(
        text.path, wanted="a header row that begins with X[s]", found="none", do="Export the file again."
    )


def _statement(path: Path, number: int, line: str) -> tuple[str, Column]:
    match = _LABEL.fullmatch(line)
    try:
        if match is None:
            raise ValueError(line)
        unit = canonical(match["unit"]) or None
        return match["label"], Column(
            match["label"], unit, 0, fs_hz=float(match["fs"].replace(",", ".")),
            start_s=float(match["start"].replace(",", ".")), expected=int(match["n"]),
        )  # fmt: skip
    except ValueError as error:
        raise RecordingError(
            f"{path}, line {number}", wanted="Label, Sampling frequency, Number of points, start, Unit, Domain Unit",
            found=repr(line[:120]), do="Export the file again.",
        ) from error  # fmt: skip


def _pairs(path: Path, number: int, labels: list[str]) -> list[Column]:
    while labels and not labels[-1]:
        labels = labels[:-1]
    for i, label in enumerate(labels):
        if (re.fullmatch(r"X\s*\[s\]", label) is not None) != (i % 2 == 0):
            raise RecordingError(
                f"{path}, line {number}, column {i + 1}", wanted="X[s]" if i % 2 == 0 else "a channel name",
                found=repr(label), do="Export the channels with a time column each, as EMGworks does.",
            )  # fmt: skip
    columns = []
    for i in range(1, len(labels), 2):
        name, unit = split_unit(labels[i])
        notes: tuple[str, ...] = ()
        if unit is None and re.search(r"\bEMG\b", name):
            unit, notes = "V", ("EMGworks writes EMG in V; this export does not state it.",)
        columns.append(Column(name, unit, i, i - 1, digits=_TIME_DIGITS, notes=notes))
    return columns


def _with_statements(path: Path, channels: list[Column], stated: list[tuple[str, Column]]) -> list[Column]:
    if [label for label, _ in stated] != [column.name for column in channels]:
        raise RecordingError(
            path, wanted=f"the {len(stated)} channels of the Label lines in the header row",
            found=", ".join(repr(column.name) for column in channels[:12]), do="Export the file again.",
        )  # fmt: skip
    return [
        replace(column, unit=said.unit, fs_hz=said.fs_hz, start_s=said.start_s, expected=said.expected, notes=())
        for column, (_, said) in zip(channels, stated, strict=True)
    ]
