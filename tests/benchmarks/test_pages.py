"""How pages look, told of a page whose words, figures and faults are known."""

from __future__ import annotations

import sys

import pytest

from benchmarks import pages
from benchmarks.browser import CHROMIUM, running

PAGE = """<!DOCTYPE html><html lang="en"><head><title>A page</title>
<meta name="viewport" content="width=device-width"></head><body><main><h1>One two</h1>
<p>three<b>four</b></p><svg viewBox="0 0 4 1" width="400" role="img" aria-label="A line"><text>five</text></svg>
<details><summary>six seven</summary><p>eight nine ten</p><svg viewBox="0 0 4 1" width="400"></svg></details>
<div style="width:900px">eleven</div><div style="break-before:page">twelve</div></main></body></html>"""


@pytest.mark.slow
@pytest.mark.skipif(CHROMIUM is None, reason="Chromium is not installed")
def test_what_is_open_wide_and_printed_is_counted(tmp_path):
    (tmp_path / "index.html").write_text(PAGE)
    ((name, address),) = pages.files_of(tmp_path)
    with running(tmp_path / "browser") as browser:
        seen = pages.look_at(browser, name, address, None, tmp_path)
    narrow = seen["forms"]["420 dark"]
    assert seen["pages"] == 2
    assert (narrow["words"], narrow["with_summaries"], narrow["figures"]) == (6, 8, 1)
    assert narrow["overflow"] > 400
    assert seen["forms"]["1280 light"]["overflow"] <= 0
    assert (tmp_path / f"{name}-420-dark.png").stat().st_size > 1000
    assert f"| {name} | 420 dark | 6 | 8 | 1 |" in "\n".join(pages.tell(seen))


@pytest.mark.parametrize(
    ("words", "said"),
    [(["nowhere.html"], "nowhere.html: expected a page"), (["--axe", "axe.js"], "--axe axe.js: expected axe.min.js")],
)
def test_what_is_not_there_is_said(words, said, monkeypatch):
    monkeypatch.setattr(sys, "argv", ["pages", *words])
    with pytest.raises(SystemExit, match=said):
        pages.main()
