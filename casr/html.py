"""Pages: the HTML pieces they are made of, and their one look. ``text`` is escaped here; ``body`` is HTML already."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from html import escape

from casr.palette import ON_PAGES

_BY_DAY, _BY_NIGHT = ("".join(f"--{name}:{both[k]};" for name, *both in ON_PAGES) for k in (0, 1))
CSS = (
    f"""
:root{{{_BY_DAY}color-scheme:light dark}}
@media screen and (prefers-color-scheme:dark){{:root{{{_BY_NIGHT}}}figure img{{filter:brightness(.86)}}}}
"""
    + """
*{box-sizing:border-box}
body{margin:0;font:16px/1.5 system-ui,"Segoe UI","DejaVu Sans",Arial,sans-serif;color:var(--ink);background:var(--page)}
header,nav,main,footer{max-width:68rem;margin:0 auto;padding:0 1rem}
h1{font-size:1.6rem;line-height:1.2;margin:1.2rem 0 .3rem;overflow-wrap:anywhere}
h2{font-size:1.3rem;margin:2rem 0 .4rem;padding-top:.5rem;border-top:1px solid var(--line)}
h3{font-size:1.05rem;margin:1.4rem 0 .3rem}
p,ul{max-width:46rem;margin:.5rem 0}
a{color:var(--link)}
nav ul{display:flex;flex-wrap:wrap;gap:.2rem 1rem;list-style:none;padding:0;max-width:none}
.sub,figcaption,caption,.small{color:var(--muted);font-size:.9rem}
.say{border-left:4px solid var(--ink);background:var(--soft);padding:.5rem .8rem;max-width:46rem;margin:.8rem 0}
.good{border-color:#009E73}.usable{border-color:#E69F00}.bad,.repeat,.unreadable{border-color:#D55E00}
.say strong:first-child{font-size:1.1rem}
.tiles{display:flex;flex-wrap:wrap;gap:.6rem;padding:0;margin:.8rem 0;list-style:none;max-width:none}
.tiles li{border:1px solid var(--line);padding:.4rem .8rem;min-width:8rem;flex:0 1 auto}
.tiles b{display:block;font-size:1.2rem}
.pictures{display:grid;grid-template-columns:repeat(auto-fill,minmax(min(100%,27rem),1fr));gap:1.2rem;align-items:start}
.small-ones{grid-template-columns:repeat(auto-fill,minmax(min(100%,13rem),1fr))}
figure{margin:1rem 0}
.pictures figure{margin:0}
figure h3{margin:0 0 .3rem}
figure img,figure svg{display:block;width:100%;height:auto;border-radius:.2rem}figure img{background:#fff}
.pictures img{border:1px solid var(--line)}
.wide{overflow-x:auto;background:
linear-gradient(90deg,var(--page) 2rem,transparent) 0/4rem 100% no-repeat local,
linear-gradient(-90deg,var(--page) 2rem,transparent) 100%/4rem 100% no-repeat local,
linear-gradient(90deg,#8888,transparent) 0/.8rem 100% no-repeat scroll,
linear-gradient(-90deg,#8888,transparent) 100%/.8rem 100% no-repeat scroll}
@media(max-width:40rem){.wide table{min-width:34rem}}
table{border-collapse:collapse;font-size:.86rem;margin:.8rem 0;font-variant-numeric:tabular-nums}
caption{text-align:left;padding:.2rem 0}
caption b{color:var(--ink)}
th,td{padding:.22rem .8rem .22rem 0;text-align:left;vertical-align:top}
th{border-bottom:1px solid var(--ink);border-top:1px solid var(--ink);vertical-align:bottom;font-weight:600}
tbody th{border-top:0}
td,tbody th{border-bottom:1px solid var(--line);font-weight:inherit}
.n{text-align:right}
.verdict{font-weight:600;min-width:6.5rem}td>a{text-decoration:none}td>a:hover{text-decoration:underline}
.holds .verdict{color:var(--good)}.fails .verdict{color:var(--bad)}.untested .verdict{color:var(--muted)}
details{margin:.5rem 0}
summary{cursor:pointer;color:var(--link)}
dl{display:grid;grid-template-columns:minmax(5rem,auto) minmax(0,1fr);gap:.2rem 1rem;max-width:52rem;margin:.5rem 0}
dt{font-weight:600}dd{margin:0;overflow-wrap:anywhere}
code{font-size:.85rem;overflow-wrap:anywhere}
footer{margin:2rem auto}
@media(min-width:72rem){
.side{display:grid;grid-template-columns:14rem minmax(0,62rem);column-gap:1.5rem;justify-content:center;padding:0 1rem}
.side>header,.side>main,.side>footer{grid-column:2;margin-left:0;margin-right:0;padding:0;max-width:none;width:100%}
.side>nav{grid-column:1;grid-row:1/span 3;position:sticky;top:0;align-self:start;max-height:100vh;overflow:auto;
margin:0;padding:1.2rem 0;font-size:.9rem}
.side>nav ul{display:block}.side>nav li{margin:.25rem 0}.side>nav a{text-decoration:none}}
.skip{position:absolute;left:-99rem}.skip:focus{left:1rem;top:.5rem;background:var(--page)}
@page{size:A4;margin:14mm 12mm}
@media print{nav,.skip{display:none}body{font-size:10pt}.wide{overflow:visible;background:none}
figure,tr,.say{break-inside:avoid}figure svg{min-width:0!important;max-height:225mm}
.pictures{grid-template-columns:1fr 1fr;gap:.5rem}
thead{display:table-header-group}
caption,h2,h3,summary,thead,tbody tr:first-child,tr:nth-last-child(2){break-after:avoid}p{orphans:3;widows:3}
.wide table{min-width:0;font-size:7pt}th,td{padding-right:.3rem}td.n{white-space:nowrap}
a{color:inherit;text-decoration:none}summary{list-style:none;color:inherit}
summary[data-file]::after{content:": " attr(data-file);color:var(--muted)}
details:not(:has(>summary[data-file]))::details-content{content-visibility:visible;display:block;height:auto}}
"""
)
"""Readable on a phone, by night and on paper; no fonts or scripts from elsewhere.

A wide screen keeps the contents at its left side. What is wider than the page scrolls sideways, with a shadow at the
edge behind which there is more. Paper shows what is folded, or the name of its file where there is one; a table is not
parted from its head.
"""


def page(title: str, header: str, nav: Iterable[tuple[str, str]], body: str, footer: str) -> str:
    """A whole document. header, footer : HTML. nav : (address, text) of each link, if any."""
    links = "".join(f'<li><a href="{escape(address)}">{escape(text)}</a></li>' for address, text in nav)
    skip = '<a class="skip" href="#main">Skip to content</a>\n' if links else ""
    contents = f'<nav aria-label="Contents"><ul>{links}</ul></nav>\n' if links else ""
    style = CSS.strip().replace("\n", "")
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width,initial-scale=1">\n'
        f"<title>{escape(title)}</title>\n<style>{style}</style>\n</head>\n"
        f"<body{_attribute('class', 'side' if links else '')}>\n"
        f'{skip}<header>{header}</header>\n{contents}<main id="main">\n{body}</main>\n'
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
    return f"<p{_attribute('class', kind)}>{escape(text)}</p>\n"


def statement(kind: str, strong: str, text: str) -> str:
    """A sentence nobody may miss."""
    return f'<p class="say{" " + kind if kind else ""}"><strong>{escape(strong)}</strong> {escape(text)}</p>\n'


def bullets(texts: Iterable[str]) -> str:
    items = "".join(f"<li>{escape(text)}</li>" for text in texts)
    return f"<ul>{items}</ul>\n" if items else ""


def tiles(facts: Iterable[tuple[str, str, str]]) -> str:
    """Name, value and a remark of each number."""
    items = "".join(f"<li>{escape(name)}<b>{escape(value)}</b>{escape(remark)}</li>" for name, value, remark in facts)
    return f'<ul class="tiles">{items}</ul>\n'


def details(summary: str, body: str, file: str = "") -> str:
    """Folded away until asked for. file : address of the same as a file, which paper shows in place of ``body``."""
    if not file:
        return f"<details><summary>{escape(summary)}</summary>\n{body}</details>\n"
    link = f'<p class="small"><a href="{escape(file)}" download>{escape(file)}</a></p>\n'
    return f'<details><summary data-file="{escape(file)}">{escape(summary)}</summary>\n{body}{link}</details>\n'


def pairs(facts: Iterable[tuple[str, str]]) -> str:
    """Names and what they stand for."""
    return "<dl>" + "".join(f"<dt>{escape(name)}</dt><dd>{escape(value)}</dd>" for name, value in facts) + "</dl>\n"


def figure(svg: str, caption: str) -> str:
    """A drawing, HTML, with its caption."""
    label = escape(re.split(r"\.(?!\d)", caption.removeprefix("Fig. "))[0])
    return (
        f'<figure><div class="wide" role="region" tabindex="0" aria-label="Figure: {label}">{svg}</div>'
        f"<figcaption>{escape(caption)}</figcaption>\n</figure>\n"
    )


def pictures(figures: Iterable[str], *, small: bool = False) -> str:
    """Figures beside each other, as many as there is room for; each is HTML."""
    drawn = "".join(figures)
    return f'<div class="pictures{" small-ones" if small else ""}">{drawn}</div>\n' if drawn else ""


def table(
    caption: str, heads: Sequence[str], rows: Iterable[Sequence[str]], links: Sequence[str] = (), *, number: int = 0,
    classes: Sequence[str] | None = None, kinds: Sequence[str] = (), groups: Sequence[str] = (),
) -> str:  # fmt: skip
    """Scrolls sideways.

    links : addresses of the cells of the first column, "" for none. number : of the table on its page, 0 for none.
    classes : of the columns, n for numbers; without them the first holds names and the others numbers. kinds : classes
    of the rows. groups : a heading of each row; neighbours share theirs.
    """
    classes = classes or ["", *["n"] * (len(heads) - 1)]
    of = [_attribute("class", kind) for kind in classes]
    top = "".join(f'<th scope="col"{k}>{escape(head)}</th>' for k, head in zip(of, heads, strict=True))
    body = []
    for place, row in enumerate(rows):
        cells = [escape(text) for text in row]
        if links and links[place]:
            cells[0] = f'<a href="{escape(links[place])}">{cells[0]}</a>'
        if groups and (not place or groups[place] != groups[place - 1]):
            body.append(f'<tr><th colspan="{len(heads)}" scope="colgroup">{escape(groups[place])}</th></tr>')
        kind = _attribute("class", kinds[place]) if kinds else ""
        body.append(f"<tr{kind}>" + "".join(f"<td{k}>{cell}</td>" for k, cell in zip(of, cells, strict=True)) + "</tr>")
    joined, named = "\n".join(body), f"Table {number}." if number else ""
    return (
        f'<div class="wide" role="region" tabindex="0" aria-label="{f"{named} {escape(caption)}".lstrip()}"><table>'
        f"<caption>{f'<b>{named}</b> ' if number else ''}{escape(caption)}</caption>\n"
        f"<thead><tr>{top}</tr></thead>\n<tbody>\n{joined}\n</tbody></table></div>\n"
    )


def _attribute(name: str, text: str) -> str:
    return f' {name}="{escape(text)}"' if text else ""
