"""One table, written as CSV (every digit, for programs), as LaTeX and as HTML (rounded, for people)."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

import numpy as np

from emg2vsa.report.wording import UNDEFINED, number

Cell = str | int | float | bool | None


@dataclass(frozen=True)
class Column:
    """key : name in CSV, with its unit. head : for people. factor, digits : how a number is shown to people."""

    key: str
    head: str
    factor: float = 1.0
    digits: int = 3

    def shown(self, value: Cell) -> str:
        if value is None:
            return UNDEFINED
        if isinstance(value, bool):
            return "yes" if value else "no"
        if isinstance(value, str):
            return value
        return number(value * self.factor if self.factor != 1 else value, self.digits)


@dataclass(frozen=True)
class Table:
    """``rows`` hold plain values, one per column."""

    name: str
    caption: str
    columns: tuple[Column, ...]
    rows: tuple[tuple[Cell, ...], ...]

    def csv(self) -> str:
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow([column.key for column in self.columns])
        writer.writerows([_exact(value) for value in row] for row in self.rows)
        return text.getvalue()

    def latex(self) -> str:
        """A booktabs table with caption and label."""
        heads = " & ".join(latex_text(column.head) for column in self.columns)
        lines = [" & ".join(map(latex_text, cells)) + r" \\" for cells in self._shown_rows()]
        alignment = "".join("r" if numeric else "l" for numeric in self._numeric())
        return "\n".join(
            [
                r"\begin{table}", r"\centering", rf"\caption{{{latex_text(self.caption)}}}",
                rf"\label{{tab:{self.name}}}", rf"\begin{{tabular}}{{{alignment}}}",
                r"\toprule", heads + r" \\", r"\midrule", *lines, r"\bottomrule",
                r"\end{tabular}", r"\end{table}", "",
            ]
        )  # fmt: skip

    def html(self) -> str:
        """Scrolls sideways on a narrow screen."""
        classes = ["n" if numeric else "" for numeric in self._numeric()]
        cell = {"": "<td>", "n": '<td class="n">'}
        heads = "".join(
            f'<th scope="col"{" class=n" if kind else ""}>{escape(column.head)}</th>'
            for column, kind in zip(self.columns, classes, strict=True)
        )
        body = "\n".join(
            "<tr>"
            + "".join(f"{cell[kind]}{escape(text)}</td>" for kind, text in zip(classes, cells, strict=True))
            + "</tr>"
            for cells in self._shown_rows()
        )
        label = escape(self.caption)
        return (
            f'<div class="wide" role="region" tabindex="0" aria-label="{label}"><table><caption>{label}</caption>\n'
            f"<thead><tr>{heads}</tr></thead>\n<tbody>\n{body}\n</tbody></table></div>\n"
        )

    def _numeric(self) -> list[bool]:
        return [
            any(isinstance(row[i], (int, float)) and not isinstance(row[i], bool) for row in self.rows)
            for i in range(len(self.columns))
        ]

    def _shown_rows(self) -> list[list[str]]:
        return [[column.shown(value) for column, value in zip(self.columns, row, strict=True)] for row in self.rows]


def rows_of(*arrays: Sequence[Cell] | np.ndarray) -> tuple[tuple[Cell, ...], ...]:
    """Rows of plain values from columns of equal length."""
    columns = [array.tolist() if isinstance(array, np.ndarray) else list(array) for array in arrays]
    return tuple(zip(*columns, strict=True))


_LATEX = {
    "\\": r"\textbackslash{}", "&": r"\&", "%": r"\%", "$": r"\$", "#": r"\#", "_": r"\_", "{": r"\{", "}": r"\}",
    "~": r"\textasciitilde{}", "^": r"\textasciicircum{}", "<": r"\ensuremath{<}", ">": r"\ensuremath{>}",
    "µ": r"\ensuremath{\mu}", "²": r"\ensuremath{^2}", "η": r"\ensuremath{\eta}", "κ": r"\ensuremath{\kappa}",
    "α": r"\ensuremath{\alpha}", "–": "--", "·": r"\ensuremath{\cdot}", "±": r"\ensuremath{\pm}",
    "−": r"\ensuremath{-}", "≤": r"\ensuremath{\le}", "\N{NO-BREAK SPACE}": "~",
}  # fmt: skip


def latex_text(text: str) -> str:
    """Plain text as LaTeX: special characters escaped, the few symbols of the tables as mathematics."""
    return "".join(_LATEX.get(character, character) for character in text)


def _exact(value: Cell) -> Cell:
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return ""
    return repr(value) if isinstance(value, float) else value
