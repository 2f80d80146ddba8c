"""Motion Analysis EVaRT and Cortex analogue files (``.anc``): 11 header lines, then tab-separated rows of counts.

Rows begin with the time; rate and bits of the converter stand in line 4, names, rates and ranges (mV) in lines 9 to 11.
A count is 2 x Range / 2^BitDepth millivolts at the converter, checked for 16 bits on a file and its C3D twin; gains of
amplifiers before it are not in the file.
"""

from __future__ import annotations

import re
from pathlib import Path

from emg2vsa.errors import RecordingError
from emg2vsa.readers.cells import Body
from emg2vsa.readers.opened import Contents, unique_names
from emg2vsa.readers.plain_csv import widest
from emg2vsa.readers.table_head import SNIFFED_ROWS
from emg2vsa.readers.text_file import Dialect, open_text, without_cut_line
from emg2vsa.readers.timed_columns import Column, TimedColumns

_HEADER_LINES = 11
_CHECKED_BITS = 16
_DIALECT = Dialect("\t", ".")


def open_recording(path: Path) -> TimedColumns:
    """Read the header. Raises RecordingError for a damaged one; cells are checked when they are read."""
    text, cut = without_cut_line(open_text(path))
    head = [line for _, line in zip(range(_HEADER_LINES), text.lines(), strict=False)]
    tables = {cells[0]: cells[1:] for line in head if (cells := _DIALECT.split(line.text))}
    stated = " ".join(line.text for line in head[:4])
    bits, fs_hz = _stated(path, stated, r"BitDepth:\s*(\d{1,2})\b"), _stated(path, stated, r"PreciseRate:\s*([\d.]+)")
    names, ranges_mv = tables.get("Name", []), tables.get("Range", [])
    while names and not names[-1] and len(names) > len([cell for cell in ranges_mv if cell]):
        names = names[:-1]  # the blank cell behind the last tab
    if not names or len(ranges_mv) < len(names):
        raise _damaged(path, f"{len(names)} names and {len(ranges_mv)} ranges")
    rows = text.filled_lines(SNIFFED_ROWS, head[-1].end, head[-1].number + 1)
    if not rows:
        raise _damaged(path, "no rows below the header")
    note = (
        f"Counts became mV at the converter by its range (2 x Range / 2^{bits:.0f}); divide by the amplifier's gain, "
        "which the file does not state."
    )
    if bits != _CHECKED_BITS:
        note += f" This rule was checked for {_CHECKED_BITS} bits only."
    columns = []
    for i, (name, range_mv) in enumerate(zip(unique_names(names), ranges_mv, strict=False), start=1):
        try:
            scale = 2 * float(range_mv) / 2**bits
            if not 0 < scale < 1e9:
                raise ValueError(range_mv)
        except ValueError as error:
            raise _damaged(path, f"{range_mv!r} as the range of {name!r}") from error
        columns.append(Column(name, "mV", i, 0, 1.0, fs_hz, scale=scale, notes=(note,)))
    body_data = text.data[head[-1].end :]
    body = Body(path, body_data, head[-1].number + 1, _DIALECT, widest(_DIALECT, rows), len(names) + 2)
    return TimedColumns(path, Contents(tuple(column.name for column in columns), notes=cut), body, tuple(columns))


def _stated(path: Path, header: str, pattern: str) -> float:
    match = re.search(pattern, header)
    try:
        value = float(match[1]) if match else 0.0
    except ValueError:
        value = 0.0
    if not 0 < value < 1e9:
        raise _damaged(path, f"no {pattern.partition(':')[0]} in its first lines")
    return value


def _damaged(path: Path, found: str) -> RecordingError:
    return RecordingError(
        path, wanted="an analogue file of EVaRT or Cortex", found=found,
        do="Export the recording again, as C3D if need be.",
    )  # fmt: skip
