"""Tables as LaTeX that fits the page: broken heads and texts, small type for wide tables, long ones over pages."""

from __future__ import annotations

from textwrap import wrap

from emg2vsa.report.table import Table

_ONE_COLUMN, _TWO_COLUMNS = 45, 96
"""Characters that fit an IEEE column, and both, at the size of tables."""
_HEAD = 11
_LONG_TEXT = 28
_LONG_TABLE = 45
"""Rows from which a table goes over pages."""

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


def latex_table(table: Table) -> str:
    """A booktabs table with caption and label; its first line names the packages it takes."""
    cells, numeric = table.cells(), table.numeric()
    lengths = [max((len(row[i]) for row in cells), default=1) for i in range(len(table.columns))]
    texts = [length > _LONG_TEXT for length in lengths]
    heads = [
        _head(column.head, max(length, _HEAD), "r" if number else "l", broken=not text)
        for column, length, number, text in zip(table.columns, lengths, numeric, texts, strict=True)
    ]
    kinds = [_LONG if text else "r" if number else "l" for text, number in zip(texts, numeric, strict=True)]
    lines = [" & ".join(map(latex_text, row)) + r" \\" for row in cells]
    caption, top = rf"\caption{{{latex_text(table.caption)}}}", [r"\toprule", " & ".join(heads) + r" \\", r"\midrule"]
    label = rf"\label{{tab:{table.name}}}"
    size = _size(sum(length + 2 for length in lengths))
    made = (
        _over_pages(kinds, caption, label, top, lines, size)
        if len(cells) >= _LONG_TABLE
        else _on_one_page(kinds, caption, label, top, lines, size, any(texts) or size != "")
    )
    return "\n".join([*made, ""])


_LONG = r">{\raggedright\arraybackslash}X"


def _head(head: str, width: int, side: str, *, broken: bool) -> str:
    """A head in lines as short as its column, so that numbers and not words make a table wide."""
    lines = wrap(head, width, break_long_words=False) if broken else [head]
    if len(lines) == 1:
        return latex_text(head)
    return rf"\begin{{tabular}}[b]{{@{{}}{side}@{{}}}}" + r"\\".join(map(latex_text, lines)) + r"\end{tabular}"


def _size(characters: int) -> str:
    """Type size and distance of columns of a table of so many characters across."""
    if characters <= _ONE_COLUMN:
        return ""
    return r"\footnotesize" if characters <= _TWO_COLUMNS else r"\footnotesize\setlength{\tabcolsep}{3pt}"


def _on_one_page(
    kinds: list[str], caption: str, label: str, top: list[str], lines: list[str], size: str, wide: bool
) -> list[str]:
    table, packages = "table*" if wide else "table", "booktabs"
    tabular, width = "tabular", ""
    if _LONG in kinds:
        tabular, width, packages = "tabularx", r"{\linewidth}", "booktabs, tabularx"
    return [
        f"% takes the packages {packages}", rf"\begin{{{table}}}", r"\centering" + size, caption, label,
        rf"\begin{{{tabular}}}{width}{{{''.join(kinds)}}}", *top, *lines, r"\bottomrule", rf"\end{{{tabular}}}",
        rf"\end{{{table}}}",
    ]  # fmt: skip


def _over_pages(kinds: list[str], caption: str, label: str, top: list[str], lines: list[str], size: str) -> list[str]:
    columns = "".join(kinds).replace(_LONG, r"p{0.25\linewidth}")
    return [
        "% takes the packages booktabs and longtable, and text in one column", "{" + (size or r"\small"),
        rf"\begin{{longtable}}{{{columns}}}", caption + label + r" \\", *top, r"\endfirsthead", *top, r"\endhead",
        r"\bottomrule", r"\endfoot", *lines, r"\end{longtable}", "}",
    ]  # fmt: skip
