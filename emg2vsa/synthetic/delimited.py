"""Numbers as delimited text, fast: one format operation over a whole table."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray


def number_rows(columns: Sequence[NDArray[np.float64]], formats: Sequence[str]) -> str:
    """CSV rows of equally long columns, each with its printf format, lines ended by a line feed."""
    table = np.column_stack(columns)
    line = ",".join(formats) + "\n"
    text: str = line * table.shape[0] % tuple(table.ravel().tolist())
    return text


def text_rows(rows: Iterable[Sequence[object]], delimiter: str) -> str:
    """Rows of any cells, quoted where needed; floats in their shortest exact form."""
    buffer = io.StringIO()
    csv.writer(buffer, delimiter=delimiter, lineterminator="\n").writerows(rows)
    return buffer.getvalue()
