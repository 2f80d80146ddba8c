"""Tables as LaTeX that fits the page: broken heads and texts, small type for wide tables, long ones over pages."""

from __future__ import annotations

import re
from textwrap import wrap

from emg2vsa.report.table import Table

_ONE_COLUMN, _TWO_COLUMNS = 45, 96
"""Characters that fit an IEEE column, and both, at the size of tables."""
_WIDEST = 130
"""What small type with narrow gaps fits; beyond, smaller type, and long tables across the page."""
_HEAD = 8
_LONG_TEXT = 28
_LONG_TABLE = 45
"""Rows from which a table goes over pages."""

_LATEX = {
    "\\": r"\textbackslash{}", "&": r"\&", "%": r"\%", "$": r"\$", "#": r"\#", "_": r"\_", "{": r"\{", "}": r"\}",
    "~": r"\textasciitilde{}", "^": r"\textasciicircum{}", "<": r"\ensuremath{<}", ">": r"\ensuremath{>}",
    "µ": r"\ensuremath{\mu}", "²": r"\ensuremath{^2}", "η": r"\ensuremath{\eta}", "κ": r"\ensuremath{\kappa}",
    "α": r"\ensuremath{\alpha}", "–": "--", "·": r"\ensuremath{\cdot}", "±": r"\ensuremath{\pm}",
    "ε": r"\ensuremath{\varepsilon}", "ρ": r"\ensuremath{\rho}", "χ": r"\ensuremath{\chi}", "₀": r"\ensuremath{_0}",
    "₁": r"\ensuremath{_1}", "∞": r"\ensuremath{\infty}", "|": r"\ensuremath{|}", "−": r"\ensuremath{-}",
    "≤": r"\ensuremath{\le}", "≥": r"\ensuremath{\ge}", "×": r"\ensuremath{\times}", "°": r"\ensuremath{^\circ}",
    "→": r"\ensuremath{\to}", "σ": r"\ensuremath{\sigma}", "\N{NO-BREAK SPACE}": "~", "ᵐ": r"\ensuremath{^m}",
    "ω": r"\ensuremath{\omega}", "“": "``", "”": "''", "’": "'",
} | {mark: rf"\ensuremath{{^{{{plain}}}}}" for mark, plain in zip("⁻⁰¹³⁴⁵⁶⁷⁸⁹", "-013456789", strict=True)}  # fmt: skip


_INDEX = re.compile(r"(?:(?<=\^2\})|(?<=\bA)(?=\\_c0\b)|(?<=\br)(?=\\_rb\b))\\_(\w+)")
"""Indices of symbols, as in ε²_R, A_c0 and r_rb; the underscore of another name stays one."""


def latex_text(text: str) -> str:
    """Plain text as LaTeX: special characters escaped, the few symbols of the tables as mathematics."""
    made = "".join(_LATEX.get(character, character) for character in text)
    return _INDEX.sub(r"\\ensuremath{_\\mathrm{\1}}", made)


def latex_number(shown: str) -> str:
    """A number as people see it, with a minus sign (of either kind) and powers of ten; other text as text."""
    if not (parts := re.fullmatch(r"(-?[0-9.]+)(?:e([-+]?[0-9]+))?", shown.replace("\N{MINUS SIGN}", "-"))):
        return latex_text(shown)
    mantissa, exponent = parts.groups()
    power = rf"\times10^{{{int(exponent)}}}" if exponent else ""
    return rf"\ensuremath{{{mantissa}{power}}}" if power or mantissa.startswith("-") else mantissa


_LONG = r">{\raggedright\arraybackslash}X"


def latex_table(table: Table) -> str:
    """A booktabs table with caption and label; its first line names the packages it takes."""
    cells, numeric = table.cells(), table.numeric()
    lengths = [max((len(row[i]) for row in cells), default=1) for i in range(len(table.columns))]
    kinds = [_LONG if of > _LONG_TEXT else "r" if n else "l" for of, n in zip(lengths, numeric, strict=True)]
    # numbers and not words make a table wide
    heads = [
        wrap(column.head, max(length, _HEAD), break_long_words=False)
        for column, length in zip(table.columns, lengths, strict=True)
    ]
    lines = [
        " & ".join(latex_number(cell) if n else latex_text(cell) for cell, n in zip(row, numeric, strict=True)) + r" \\"
        for row in cells
    ]
    if _LONG in kinds:
        # rows of several lines are told apart by a little space
        lines[:-1] = [rf"{line} \addlinespace" for line in lines[:-1]]
    size = _size(sum(max(length, *map(len, head)) + 2 for length, head in zip(lengths, heads, strict=True)))
    head = " & ".join(_head(each, "r" if n else "l") for each, n in zip(heads, numeric, strict=True)) + r" \\"
    caption, label = rf"\caption{{{latex_text(table.caption)}}}", rf"\label{{tab:{table.name}}}"
    layout = _over_pages if len(cells) >= _LONG_TABLE else _on_one_page
    return "\n".join([*layout(kinds, caption, label, [r"\toprule", head, r"\midrule"], lines, size), ""])


def _head(lines: list[str], side: str) -> str:
    if len(lines) == 1:
        return latex_text(lines[0])
    return rf"\begin{{tabular}}[b]{{@{{}}{side}@{{}}}}" + r"\\".join(map(latex_text, lines)) + r"\end{tabular}"


def _size(characters: int) -> str:
    """Type size and distance of columns of a table of so many characters across."""
    if characters <= _TWO_COLUMNS:
        return r"\footnotesize" if characters > _ONE_COLUMN else ""
    return (r"\footnotesize" if characters <= _WIDEST else r"\scriptsize") + r"\setlength{\tabcolsep}{3pt}"


def _on_one_page(kinds: list[str], caption: str, label: str, top: list[str], lines: list[str], size: str) -> list[str]:
    long = _LONG in kinds
    table, tabular, width = "table*" if long or size else "table", "tabular", ""
    if long:
        tabular, width = "tabularx", r"{\linewidth}"
    return [
        f"% takes the packages booktabs{', tabularx' if long else ''}", rf"\begin{{{table}}}", r"\centering" + size,
        caption, label, rf"\begin{{{tabular}}}{width}{{{''.join(kinds)}}}", *top, *lines, r"\bottomrule",
        rf"\end{{{tabular}}}", rf"\end{{{table}}}",
    ]  # fmt: skip


def _over_pages(kinds: list[str], caption: str, label: str, top: list[str], lines: list[str], size: str) -> list[str]:
    columns = "".join(kinds).replace(_LONG, r"p{0.25\linewidth}")
    packages, begin, end = "booktabs and longtable", "{", "}"
    if r"\scriptsize" in size:
        packages, begin, end = "booktabs, longtable and lscape", r"\begin{landscape}", r"\end{landscape}"
    return [
        f"% takes the packages {packages}, and text in one column",
        begin + (size or r"\small") + r"\setlength{\LTcapwidth}{\linewidth}",
        rf"\begin{{longtable}}{{{columns}}}", caption + label + r" \\", *top, r"\endfirsthead", *top, r"\endhead",
        r"\bottomrule", r"\endfoot", *lines, r"\end{longtable}", end,
    ]  # fmt: skip
