"""The pages that people write: what they link and name is there, layers and stages are those of the code."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from emg2vsa.pipeline.stage_order import ORDER

ROOT = Path(__file__).resolve().parent.parent
DOCS = ROOT / "docs"
PAGES = [
    ROOT / "README.md",
    ROOT / "CHANGELOG.md",
    ROOT / "CONTRIBUTING.md",
    *(ROOT / f"{name}.md" for name in ("SECURITY", "SUPPORT", "GOVERNANCE")),
    *sorted(path for path in DOCS.rglob("*.md") if not {"_build", "made"} & set(path.parts)),
]
ARCHITECTURE = (DOCS / "architecture.md").read_text(encoding="utf-8")


def anchors(page: Path) -> set[str]:
    """Names of the headings of a page, as links write them."""
    titles = re.findall(r"^#+ (.+)$", page.read_text(encoding="utf-8"), flags=re.M)
    return {re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in titles}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_every_link_leads_somewhere(page: Path) -> None:
    prose = re.sub(r"```.*?```", "", page.read_text(encoding="utf-8"), flags=re.S)
    links = [link for link in re.findall(r"\]\(([^)\s]+)\)", prose) if "://" not in link]
    for file, _, name in (link.partition("#") for link in links):
        target = page.parent / file if file else page
        assert target.exists(), file
        assert not name or name in anchors(target), f"{file}#{name}"


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_every_module_that_is_named_is_there(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    files = set(re.findall(r"`([\w/]+\.py)`", text))
    files |= {
        name.replace(".", "/") + ".py" for name in re.findall(r"python -m ((?:emg2vsa|casr|benchmarks)[\w.]*)", text)
    }
    places = (ROOT, ROOT / "emg2vsa", ROOT / "casr", ROOT / "emg2vsa" / "pipeline")
    left = {name for name in files if not any((place / name).exists() for place in places)}
    assert {name for name in left if not (ROOT / name[:-3] / "__main__.py").exists()} == set()


def test_the_page_shows_every_stage() -> None:
    drawn = ARCHITECTURE.partition("## The stages")[2].partition("```")[2].partition("```")[0]
    assert set(re.findall(r"[a-z]+", drawn)) >= set(ORDER)
