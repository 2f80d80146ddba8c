"""ATI Net F/T demo: the CSV that ATI's Java program writes.

A start time, ``RDT Sample Rate``, units, ``Counts per Unit Force`` and ``... Torque``, then rows ``Status (hex), RDT
Sequence, F/T Sequence, Fx, Fy, Fz, Tx, Ty, Tz, Time``, all quoted. Versions differ in what they write: counts (whole
numbers), which are divided here, or values in the stated unit (with a decimal point). The RDT sequence says which
samples were lost. Layout: ATI's NetFTSampleGUI.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from emg2vsa.errors import RecordingError
from emg2vsa.readers.cells import Body
from emg2vsa.readers.on_demand import OnDemand, Track, counted
from emg2vsa.readers.opened import Contents
from emg2vsa.readers.plain_csv import widest
from emg2vsa.readers.table_head import SNIFFED_ROWS
from emg2vsa.readers.text_file import Dialect, open_text, without_cut_line
from emg2vsa.readers.units import canonical

_DIALECT = Dialect(",", ".")
_AXES = ("Fx", "Fy", "Fz", "Tx", "Ty", "Tz")
_COUNTER = "RDT Sequence"
_WRAPS = 2**32


def open_recording(path: Path) -> OnDemand:
    """Read header and sequence. Raises RecordingError for a damaged header; cells are checked when they are read."""
    text, cut = without_cut_line(open_text(path))
    stated: dict[str, str] = {}
    for line in text.lines():
        if line.text.lstrip('"').startswith("Status (hex)"):
            break
        key, colon, value = line.text.partition(":")
        if colon:
            stated[key.strip()] = value.strip()
    else:
        raise _damaged(path, "no row of names that begins with 'Status (hex)'")
    labels = _DIALECT.split(line.text)
    missing = [name for name in (_COUNTER, *_AXES) if name not in labels]
    if missing:
        raise _damaged(path, f"no column {missing[0]!r}")
    data = text.data[line.end :]
    if not data.strip():
        raise _damaged(path, "no rows")
    rows_seen = text.filled_lines(SNIFFED_ROWS, line.end, line.number + 1)
    body = Body(path, data, line.number + 1, _DIALECT, widest(_DIALECT, rows_seen), len(labels))
    fs_hz = _number(path, stated, "RDT Sample Rate")
    at = {axis: labels.index(axis) for axis in _AXES}
    first = _DIALECT.split(next(text.lines(line.end)).text)
    whole = all(re.fullmatch(r"-?\d+", first[i]) for i in at.values() if i < len(first))
    counter = labels.index(_COUNTER)
    rows = counted(body.columns({counter: _COUNTER})[counter], _COUNTER, fs_hz, _WRAPS)
    tracks, scales = [], []
    for axis in _AXES:
        kind = "Force" if axis.startswith("F") else "Torque"
        counts = _number(path, stated, f"Counts per Unit {kind}") if whole else 1.0
        unit = canonical(stated.get(f"{kind} Units", ""))
        said = f"{axis}: counts / {counts:.10g} = {unit}." if whole else f"{axis}: written in {unit} already."
        tracks.append(Track(axis, unit or None, fs_hz, rows.n_samples, notes=(*rows.notes, said)))
        scales.append(counts)

    def decode(indices: Sequence[int]) -> list[NDArray[np.float64]]:
        columns = body.columns({at[_AXES[i]]: _AXES[i] for i in indices})
        return [rows.placed(columns[at[_AXES[i]]]) / scales[i] for i in indices]

    return OnDemand(path, Contents(_AXES, notes=cut, started=stated.get("Start Time", "")), tuple(tracks), decode)


def _number(path: Path, stated: dict[str, str], key: str) -> float:
    try:
        value = float(stated.get(key, ""))
        if not 0 < value < 1e12:
            raise ValueError(value)
    except ValueError as error:
        raise _damaged(path, f"{stated.get(key)!r} as {key}") from error
    return value


def _damaged(path: Path, found: str) -> RecordingError:
    return RecordingError(
        path, wanted="a CSV of ATI's Net F/T demo", found=found, do="Collect the data again, or export a plain CSV."
    )
