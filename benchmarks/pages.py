"""How pages look to people: words and figures open, overflow, pages of paper, accessibility, pictures of the screen.

Run as ``python -m benchmarks.pages [FILE or FOLDER] ... [--live] [--axe axe.min.js] [--pictures DIR] [--json]``; it
prints Markdown. A folder is that of a report: its page and the first participant's. ``--live`` adds what has no file: a
press scored by casr, a run that is watched, and the two pages of a session, all emulated. Every page is opened at 1280
and 420 px, light and dark. axe-core comes with ``npm i --prefix DIR axe-core``; the file is
``DIR/node_modules/axe-core/axe.min.js``.
"""

from __future__ import annotations

import argparse
import base64
import json
import re
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from itertools import islice
from pathlib import Path
from typing import Any

from benchmarks.browser import Browser, Window, running
from benchmarks.small_study import SIMULATED_SESSION, small_study

FORMS = ((1280, "light"), (1280, "dark"), (420, "light"), (420, "dark"))
"Width in px and colours."
TALLEST_PX = 16_000
"Of a picture of the screen: Chromium draws no more."
OPEN = """(() => {
  const body = document.body.cloneNode(true);
  const drop = (what) => body.querySelectorAll(what).forEach((one) => one.remove());
  drop("script, style, noscript, svg, details:not([open]) > :not(summary)");
  const words = (node) => node.textContent.split(/\\s+/).filter(Boolean).length;
  body.querySelectorAll("*").forEach((one) => { one.prepend(" "); one.append(" "); });
  const all = words(body);
  drop("details:not([open])");
  const seen = (one) => one.getClientRects().length && one.getBoundingClientRect().width > 100
    && !one.closest("details:not([open])");
  return {
    words: words(body), with_summaries: all,
    figures: [...document.querySelectorAll("svg, img, canvas")].filter(seen).length,
    tables: [...document.querySelectorAll("table")].filter(seen).length,
    height: document.documentElement.scrollHeight,
    overflow: document.documentElement.scrollWidth - document.documentElement.clientWidth,
  };
})()"""
UNFOLD = "document.querySelectorAll('details').forEach((one) => { one.open = %s; })"
AXE = """axe.run(document, {resultTypes: ["violations"]}).then((found) => found.violations.map(
  (one) => [one.id, one.impact, one.nodes.length, one.nodes[0].target.join(" ")]))"""


def violations(window: Window, axe: str) -> list[str]:
    """What axe finds, as it stands and with everything unfolded."""
    found: dict[str, str] = {}
    window.value(f"void (0, eval)({json.dumps(axe)})")
    for unfolded in ("false", "true"):
        window.value(UNFOLD % unfolded)
        for rule, impact, times, where in window.value(AXE):
            found.setdefault(rule, f"{rule} ({impact}, {times} times, first at {where})")
    window.value(UNFOLD % "false")
    return list(found.values())


def a4_pages(window: Window, file: Path | None) -> int:
    """Of the page in print; ``file`` is where the PDF is written."""
    pdf = base64.b64decode(window.call("Page.printToPDF", preferCSSPageSize=True, printBackground=True)["data"])
    if file is not None:
        file.write_bytes(pdf)
    return len(re.findall(rb"/Type\s*/Page\b(?!s)", pdf))


def whole_picture(window: Window, file: Path, width: int, height: int) -> None:
    """The page from top to end."""
    clip = {"x": 0, "y": 0, "width": width, "height": min(height, TALLEST_PX), "scale": 1}
    image = window.call("Page.captureScreenshot", format="png", clip=clip, captureBeyondViewport=True)["data"]
    file.write_bytes(base64.b64decode(image))


def look_at(browser: Browser, name: str, address: str, axe: str | None, pictures: Path | None) -> dict[str, Any]:
    """What one page is in its four forms. axe : the text of axe-core, None: not asked."""
    window = browser.open(address)
    forms = {}
    for width, scheme in FORMS:
        window.size(width, 900, scheme)
        window.value("new Promise((done) => setTimeout(done, 300))")  # pages that draw themselves draw once more
        seen = window.value(OPEN)
        seen["axe"] = None if axe is None else violations(window, axe)
        if pictures is not None:
            whole_picture(window, pictures / f"{name}-{width}-{scheme}.png", width, seen["height"])
        forms[f"{width} {scheme}"] = seen
    window.size(1280, 900)
    pages = a4_pages(window, None if pictures is None else pictures / f"{name}.pdf")
    window.close()
    return {"page": name, "pages": pages, "forms": forms}


def files_of(place: Path) -> Iterator[tuple[str, str]]:
    """Name and address of each page: a file, or the page of a report and its first participant's."""
    if not place.exists():
        sys.exit(f"{place}: expected a page or the folder of a report, but there is nothing. Run the study first.")
    found = [place] if place.is_file() else [place / "index.html", *sorted(place.glob("participants/*.html"))[:1]]
    for file in found:
        name = file.stem if file.stem != "index" else file.resolve().parent.name
        yield name, file.resolve().as_uri()


@contextmanager
def serving(*words: str, addresses: int) -> Iterator[list[str]]:
    """The addresses that a command prints while it serves them."""
    command = [sys.executable, "-m", "emg2vsa.cli", *words]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as process:
        try:
            assert process.stdout is not None
            lines = (re.search(r"http://\S+", line) for line in process.stdout)
            found = (line[0] for line in lines if line)
            told = list(islice(found, addresses))
            assert len(told) == addresses, f"emg2vsa {' '.join(words)}: ended before it served a page"
            yield told
        finally:
            process.kill()


@contextmanager
def live_pages(folder: Path) -> Iterator[list[tuple[str, str]]]:
    """A press that was scored, a run, and a session: name and address of each page."""
    casr = [sys.executable, "-m", "casr.cli"]
    subprocess.run([*casr, "simulate", folder / "presses"], check=True, stdout=subprocess.DEVNULL)
    press = next(path for path in sorted((folder / "presses").iterdir()) if path.is_dir())
    page = folder / "press.html"
    subprocess.run([*casr, "score", press, "--page", page], check=True, stdout=subprocess.DEVNULL)
    study = folder / "study.toml"
    session = f"[session]\n{SIMULATED_SESSION}repetitions = 2\n"
    study.write_text(small_study(tables=f"[window]\nexpected_trials = 2\n{session}"), encoding="utf-8")
    watched = Path("studies/palpation/runs-virtual")
    with ExitStack() as stack:
        said = stack.enter_context(
            serving("session", str(study), "--participant", "P01", "--virtual", "--port", "0", addresses=2)
        )
        found = [("press", page.as_uri()), ("operator", said[0]), ("participant-screen", said[1])]
        if watched.is_dir():
            found += [
                ("watch", stack.enter_context(serving("rig", "watch", str(watched), "--port", "0", addresses=1))[0])
            ]
        yield found


def tell(seen: dict[str, Any]) -> Iterator[str]:
    """Lines of Markdown."""
    for form, facts in seen["forms"].items():
        axe = "not asked" if facts["axe"] is None else "; ".join(facts["axe"]) or "0"
        over = f"{facts['overflow']} px" if facts["overflow"] > 0 else "none"
        yield (
            f"| {seen['page']} | {form} | {facts['words']} | {facts['with_summaries']} | {facts['figures']} | "
            f"{facts['tables']} | {facts['height'] / 900:.1f} | {over} | {seen['pages']} | {axe} |"
        )


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("places", nargs="*", type=Path, metavar="FILE or FOLDER", help="pages, or folders of reports")
    parser.add_argument("--live", action="store_true", help="the pages of a press, a run and a session as well")
    parser.add_argument("--axe", type=Path, metavar="FILE", help="axe.min.js of axe-core")
    parser.add_argument("--pictures", type=Path, metavar="DIR", help="where pictures and PDFs are written")
    parser.add_argument("--json", action="store_true")
    asked = parser.parse_args()
    if asked.axe is not None and not asked.axe.is_file():
        sys.exit(f"--axe {asked.axe}: expected axe.min.js, but there is no such file. Run npm i --prefix DIR axe-core.")
    axe = None if asked.axe is None else asked.axe.read_text(encoding="utf-8")
    if asked.pictures is not None:
        asked.pictures.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as scratch, ExitStack() as stack:
        pages = [page for place in asked.places for page in files_of(place)]
        if asked.live:
            pages += stack.enter_context(live_pages(Path(scratch)))
        browser = stack.enter_context(running(Path(scratch) / "browser"))
        seen = [look_at(browser, name, address, axe, asked.pictures) for name, address in pages]
    if asked.json:
        print(json.dumps(seen, indent=1))
        return 0
    print(
        "| page | form | words open | with folded titles | figures open | tables open | screens | overflow | A4 | axe |"
    )
    print("|---|---|---|---|---|---|---|---|---|---|")
    for page in seen:
        print("\n".join(tell(page)))
    return 0


if __name__ == "__main__":
    sys.exit(main())
