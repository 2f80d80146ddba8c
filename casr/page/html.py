"""The few HTML pieces the pages are made of. Arguments named ``text`` are escaped here; ``body`` is HTML already."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape

from casr.page.stylesheet import CSS

UNDEFINED = "–"


def document(title: str, sub: str, body: str, footer: str) -> str:
    """A whole page; ``sub`` stands under the title."""
    style = CSS.strip().replace("\n", "")
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width,initial-scale=1">\n'
        f"<title>{escape(title)}</title>\n<style>{style}</style>\n</head>\n<body>\n"
        f'<header><h1>{escape(title)}</h1><p class="sub">{escape(sub)}</p></header>\n'
        f'<main>\n{body}</main>\n<footer class="small">{escape(footer)}</footer>\n</body>\n</html>\n'
    )


def section(title: str, *body: str) -> str:
    return f"<section><h2>{escape(title)}</h2>\n{''.join(body)}</section>\n"


def paragraph(text: str) -> str:
    return f"<p>{escape(text)}</p>\n"


def statement(kind: str, strong: str, text: str) -> str:
    """A sentence nobody may miss. kind : good, usable or bad."""
    return f'<p class="say {kind}"><strong>{escape(strong)}</strong> {escape(text)}</p>\n'


def bullets(texts: Iterable[str]) -> str:
    items = "".join(f"<li>{escape(text)}</li>" for text in texts)
    return f"<ul>{items}</ul>\n" if items else ""


def tiles(facts: Iterable[tuple[str, str, str]]) -> str:
    """Name, value and a remark of each number."""
    items = "".join(f"<li>{escape(name)}<b>{escape(value)}</b>{escape(remark)}</li>" for name, value, remark in facts)
    return f'<ul class="tiles">{items}</ul>\n'


def details(summary: str, body: str) -> str:
    """Folded away until asked for."""
    return f"<details><summary>{escape(summary)}</summary>\n{body}</details>\n"


def pairs(facts: Iterable[tuple[str, str]]) -> str:
    """Names and what they stand for."""
    return "<dl>" + "".join(f"<dt>{escape(name)}</dt><dd>{escape(value)}</dd>" for name, value in facts) + "</dl>\n"


def table(caption: str, heads: Sequence[str], rows: Iterable[Sequence[str]], links: Sequence[str] = ()) -> str:
    """The first column holds names, the others numbers; ``links`` are the names' addresses. Scrolls sideways."""
    kind = ["", *[' class="n"'] * (len(heads) - 1)]
    top = "".join(f'<th scope="col"{k}>{escape(head)}</th>' for k, head in zip(kind, heads, strict=True))
    body = []
    for place, row in enumerate(rows):
        cells = [escape(text) for text in row]
        if links:
            cells[0] = f'<a href="{escape(links[place])}">{cells[0]}</a>'
        body.append("<tr>" + "".join(f"<td{k}>{cell}</td>" for k, cell in zip(kind, cells, strict=True)) + "</tr>")
    joined = "\n".join(body)
    return (
        f'<div class="wide"><table><caption>{escape(caption)}</caption>\n'
        f"<thead><tr>{top}</tr></thead>\n<tbody>\n{joined}\n</tbody></table></div>\n"
    )


def number(value: float | None, digits: int = 4) -> str:
    """Significant digits for people; a dash for what is not known."""
    if value is None or value != value:
        return UNDEFINED
    text = f"{value:.{digits}g}"
    return f"{value:.0f}" if "e+" in text and abs(value) < 1e7 else text
