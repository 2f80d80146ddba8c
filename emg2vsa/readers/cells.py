"""Number columns of a delimited text body; a cell that is no number is reported with its line and column."""

from __future__ import annotations

import io
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from emg2vsa.errors import RecordingError
from emg2vsa.readers.text_file import WHITESPACE, Dialect

_MISSING = [
    "", "NaN", "nan", "NAN", "-nan", "-NaN", "nan(ind)", "-nan(ind)", "1.#QNAN", "-1.#QNAN", "1.#IND", "-1.#IND", "-",
    "null", "NULL", "Null", "None", "#N/A", "N/A", "NA", "n/a",
]  # fmt: skip
"""Missing numbers as C libraries, spreadsheets, databases and BIDS write a number that is none."""


@dataclass(frozen=True)
class Body:
    """The data lines of a text table.

    first_line : number of the first in the file. n_fields : most cells a row has. n_allowed : most it may have, or None
    where what stands to the right of the channels does not matter.
    """

    path: Path
    data: bytes
    first_line: int
    dialect: Dialect
    n_fields: int
    n_allowed: int | None

    def columns(self, names: Mapping[int, str]) -> dict[int, NDArray[np.float64]]:
        """Decode the columns (index to the name used in messages), blank cells as NaN.

        Rows align with lines of the file. A column beyond the last cell of every row is empty. RecordingError : rows of
        too many cells, or a cell that is no number.
        """
        self._refuse_long_rows()
        wanted = sorted(column for column in names if column < self.n_fields)
        try:
            frame = self._parse(wanted, {"dtype": np.float64})
        except (ValueError, OverflowError) as error:  # pandas' ParserError is a ValueError
            raise self._no_number(names) from error
        found = {column: np.array(frame[column].to_numpy(), dtype=np.float64) for column in wanted}
        return {column: found.get(column, np.empty(0)) for column in names}

    def texts(self, column: int) -> list[str]:
        """The cells of a column as they are written, "" for blank ones. RecordingError : rows of too many cells, or no
        table."""
        self._refuse_long_rows()
        try:
            frame = self._parse([column], {"dtype": str})
        except ValueError as error:
            raise self._no_table(error) from error
        return [str(cell) for cell in frame[column].fillna("")]

    def _parse(self, wanted: list[int], how: Mapping[str, Any]) -> pd.DataFrame:
        return pd.read_csv(  # type: ignore[call-overload, no-any-return]
            io.BytesIO(self.data),
            sep=self.dialect.separator,
            decimal=self.dialect.decimal,
            header=None,
            names=range(self.n_fields),
            index_col=False,
            usecols=wanted,
            na_values=_MISSING,
            keep_default_na=False,
            skipinitialspace=True,
            skip_blank_lines=False,
            engine="c",
            **how,
        )

    def line(self, row: int) -> str:
        """Place of data row ``row`` (from 0) in the file."""
        return f"line {self.first_line + row}"

    def _refuse_long_rows(self) -> None:
        """A row with cells too many has shifted values. Counting separators shows it at the speed of a search."""
        separator = self.dialect.separator.encode()
        if self.n_allowed is None or self.dialect.separator == WHITESPACE:
            return
        lines = (self._count(b"\n") or self._count(b"\r")) + (not self.data.endswith((b"\n", b"\r")))
        if self._count(separator) <= lines * (self.n_allowed - 1) and self.n_fields <= self.n_allowed:
            return
        for row, text in enumerate(self.data.splitlines()):
            found = text.count(separator) + 1
            if found > self.n_allowed and b'"' in text:
                found = len(self.dialect.split(text.decode()))
            if found > self.n_allowed:
                raise RecordingError(
                    f"{self.path}, {self.line(row)}", wanted=f"{self.n_allowed} cells", found=str(found),
                    do="Correct the line; a decimal comma in a comma-separated file does this too.",
                )  # fmt: skip

    def _count(self, sign: bytes) -> int:
        # several times quicker than bytes.count where the sign is frequent
        return int(np.count_nonzero(np.frombuffer(self.data, np.uint8) == sign[0]))

    def _no_table(self, error: ValueError) -> RecordingError:
        return RecordingError(
            f"{self.path}, from line {self.first_line}",
            wanted="a table of numbers",
            found=str(error),
            do="Look for an open quotation mark near that row, or export the file again.",
        )

    def _no_number(self, names: Mapping[int, str]) -> RecordingError:
        wanted = sorted(column for column in names if column < self.n_fields)
        try:
            frame = self._parse(wanted, {"dtype": str})
        except ValueError as error:
            return self._no_table(error)
        foreign = "." if self.dialect.decimal == "," else ","
        first: tuple[int, int] | None = None
        for column in wanted:
            text = (
                frame[column].str.replace(foreign, "?", regex=False).str.replace(self.dialect.decimal, ".", regex=False)
            )
            bad = np.flatnonzero((pd.to_numeric(text, errors="coerce").isna() & text.notna()).to_numpy())
            if bad.size and (first is None or bad[0] < first[0]):
                first = int(bad[0]), column
        if first is None:
            return RecordingError(
                self.path, wanted="numbers", found="cells that are not numbers", do="Export the file again."
            )
        row, column = first
        return RecordingError(
            f"{self.path}, {self.line(row)}, column {names[column]!r}", wanted="a number",
            found=repr(frame[column].iloc[row]), do="Correct the cell, or leave it blank where the channel has ended.",
        )  # fmt: skip
