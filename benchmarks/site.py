"""The documentation site in a browser: what axe-core finds on every page, and what its search answers first.

Build the site with ``scripts/docs``, then ``AXE=axe.min.js python -m benchmarks.site``; it prints Markdown. axe-core
4.12.1 (MPL-2.0) comes with the package axe-playwright-python of PyPI. Pages of source code are left out.
"""

from __future__ import annotations

import functools
import json
import os
import tempfile
import threading
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

from benchmarks.bench.record import print_page
from benchmarks.browser import Window, running

SITE = Path(os.environ.get("SITE", Path(__file__).resolve().parent.parent / "docs" / "_build" / "html"))
LOOKS = ((1280, "light"), (1280, "dark"), (420, "light"))
QUERIES = ("sign = -1", "sample recordings", "docker", "watchdog", "install", "motor units", "lag", "BIDS")
_FOUND = """axe.run(document, {resultTypes: ["violations"]}).then(
  found => found.violations.map(rule => [`${rule.id} (${rule.impact})`, rule.nodes.length]))"""

_DRAWN = "new Promise(done => requestAnimationFrame(() => requestAnimationFrame(() => done(1))))"


class Quiet(SimpleHTTPRequestHandler):
    def log_message(self, *_: object) -> None:
        """Say nothing."""


@contextmanager
def served(folder: Path) -> Iterator[str]:
    """Address of a folder."""
    server = ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(Quiet, directory=folder))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    try:
        yield f"http://127.0.0.1:{server.server_port}"
    finally:
        server.shutdown()


def violations(window: Window, address: str, axe: str) -> list[Counter[str]]:
    """Elements of the page by rule, for each of LOOKS."""
    window.go(address)
    window.value(axe + ";0")
    found = []
    for width, scheme in LOOKS:
        window.size(width, 900, scheme)
        window.value(_DRAWN)
        found.append(Counter(dict(window.value(_FOUND))))
    return found


def answers(window: Window, address: str, query: str) -> list[str]:
    """The first three results of the search."""
    window.go(f"{address}/search.html")
    window.value(f"location.search = '?q=' + encodeURIComponent({json.dumps(query)})")
    window.until("location.search && document.querySelector('.search-summary')?.textContent.includes('finished')")
    links = "[...document.querySelectorAll('#search-results li > a')].map(link => link.getAttribute('href'))"
    found: list[str] = window.value(links)
    return found[:3]


def page() -> Iterator[str]:
    axe = Path(os.environ["AXE"]).read_text(encoding="utf-8")
    pages = sorted(path.relative_to(SITE).as_posix() for path in SITE.rglob("*.html") if "_modules" not in path.parts)
    found: list[Counter[str]] = [Counter() for _ in LOOKS]
    with (
        tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder,
        served(SITE) as address,
        running(Path(folder)) as browser,
    ):
        window = browser.open(f"{address}/index.html")
        answered = {query: answers(window, address, query) for query in QUERIES}
        for name in pages:
            for total, more in zip(found, violations(window, f"{address}/{name}", axe), strict=True):
                total.update(more)
    yield f"# The documentation site in a browser\n\n{__doc__.partition(chr(10) * 2)[2].replace('``', '`')}"
    yield "| width, px | look | pages | elements that axe-core finds |\n|---:|---|---:|---|"
    for (width, scheme), total in zip(LOOKS, found, strict=True):
        said = ", ".join(f"{rule} {count}" for rule, count in total.items()) or "none"
        yield f"| {width} | {scheme} | {len(pages)} | {said} |"
    yield "\n| search | first three answers |\n|---|---|"
    for query, links in answered.items():
        yield f"| {query} | {', '.join(links)} |"


if __name__ == "__main__":
    print_page(__doc__, page)
