"""The few HTML pieces the pages are made of. Arguments named ``text`` are escaped here; ``body`` is HTML already."""

from __future__ import annotations

from collections.abc import Iterable
from html import escape

from emg2vsa.report.stylesheet import CSS


def page(title: str, header: str, nav: Iterable[tuple[str, str]], body: str, footer: str) -> str:
    """A whole document. nav : (address, text) of each link."""
    links = "".join(f'<li><a href="{escape(address)}">{escape(text)}</a></li>' for address, text in nav)
    style = CSS.strip().replace("\n", "")
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width,initial-scale=1">\n'
        f"<title>{escape(title)}</title>\n<style>{style}</style>\n</head>\n<body>\n"
        f'<a class="skip" href="#main">Skip to content</a>\n<header>{header}</header>\n'
        f'<nav aria-label="Contents"><ul>{links}</ul></nav>\n<main id="main">\n{body}</main>\n'
        f"<footer>{footer}</footer>\n</body>\n</html>\n"
    )


def section(name: str, title: str, *body: str) -> str:
    """A landmark with its heading."""
    return (
        f'<section id="{escape(name)}" aria-labelledby="{escape(name)}-h">'
        f'<h2 id="{escape(name)}-h">{escape(title)}</h2>\n'
        f"{''.join(body)}</section>\n"
    )


def heading(text: str) -> str:
    return f"<h3>{escape(text)}</h3>\n"


def paragraph(text: str, kind: str = "") -> str:
    return f"<p{attribute('class', kind)}>{escape(text)}</p>\n"


def statement(kind: str, strong: str, text: str) -> str:
    """A sentence nobody may miss."""
    return f'<p class="say{" " + kind if kind else ""}"><strong>{escape(strong)}</strong> {escape(text)}</p>\n'


def bullets(texts: Iterable[str]) -> str:
    items = "".join(f"<li>{escape(text)}</li>" for text in texts)
    return f"<ul>{items}</ul>\n" if items else ""


def details(summary: str, body: str) -> str:
    """Folded away until asked for."""
    return f"<details><summary>{escape(summary)}</summary>\n{body}</details>\n"


def figure(svg: str, caption: str, data: str = "") -> str:
    """A drawing with caption; ``svg`` and ``data`` (its numbers as a table) are HTML."""
    label = escape(caption.split(".")[0])
    return (
        f'<figure><div class="wide" role="region" tabindex="0" aria-label="{label}">{svg}</div>'
        f"<figcaption>{escape(caption)}</figcaption>\n{data}</figure>\n"
    )


def attribute(name: str, text: str) -> str:
    return f' {name}="{escape(text)}"' if text else ""
