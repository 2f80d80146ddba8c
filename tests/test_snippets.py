"""Every command and every piece of Python in README and docs does what its page says, and prints what it shows."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

import pytest

from emg2vsa.cli import main
from tests.once import Once
from tests.snippets import Block, Reader, blocks_of, renewed_lines

ROOT = Path(__file__).resolve().parent.parent
NOTEBOOKS = ROOT / "docs" / "notebooks"
PAGES = {
    str(path.relative_to(ROOT)): path
    for path in [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
    if NOTEBOOKS not in path.parents and ROOT / "docs" / "_build" not in path.parents and blocks_of(path)
}
FAST = ("README.md", "docs/architecture.md", "docs/problems.md", *(f"docs/how-to/{name}.md" for name in (
    "add-a-device", "known-softness", "measured-runs", "own-dome", "tactile",
)))  # fmt: skip
PALPATION = ("docs/tutorial.md", *(f"docs/how-to/{name}.md" for name in (
    "coordinator", "dynamixel", "engineer", "session", "watch-a-run",
)))  # fmt: skip
"""Pages of which the reader has the recordings of studies/palpation and its results up to the schedules."""

_SHORTER = {
    "\nmountings = 3": "\nmountings = 1",
    "\nrepetitions = 3": "\nrepetitions = 2",
    "high-stiffness = [0, 30, 45]": "high-stiffness = [0]",
    "modular = [0, 30, 45]": "modular = [0, 30]",
    "constant-min = [0]\n": "",
    "constant-mean = [0]\n": "",
}


WHOLE = ("docs/tutorial.md", "docs/how-to/author.md")
"""Pages whose reader runs all of studies/palpation. Here the rig does 16 runs of 2 presses, not 108 of 3, for time."""


def clone(folder: Path) -> None:
    """What a clone has of studies."""
    shutil.copytree(
        ROOT / "studies", folder / "studies", ignore=shutil.ignore_patterns("data", "runs*", ".emg2vsa"),
    )  # fmt: skip


def shorten(folder: Path) -> None:
    rig = folder / "studies" / "palpation" / "rig.toml"
    text = rig.read_text(encoding="utf-8")
    for old, new in _SHORTER.items():
        assert old in text
        text = text.replace(old, new)
    rig.write_text(text, encoding="utf-8")


def palpation(folder: Path) -> None:
    """The same, with simulated recordings and their schedules."""
    clone(folder)
    study = str(folder / "studies" / "palpation" / "study.toml")
    assert main(["tools", "simulate", study, "-q"]) == 0
    assert main(["run", study, "-q", "--only", "schedules", "--jobs", "1"]) == 0


@pytest.fixture
def scratch(
    request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
    built_once: Once,
) -> Path:  # fmt: skip
    """The present folder of a reader of the page."""
    if request.param in PALPATION:
        shutil.copytree(built_once("palpation", palpation), tmp_path, dirs_exist_ok=True)
    else:
        clone(tmp_path)
    if request.param in WHOLE:
        shorten(tmp_path)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "Agg")
    monkeypatch.setenv("HOME", os.fspath(tmp_path))
    return tmp_path


def cases() -> list[object]:
    return [
        pytest.param(name, name, marks=() if name in FAST else pytest.mark.slow, id=name)
        for name in PAGES
    ]  # fmt: skip


@pytest.mark.parametrize(("page", "scratch"), cases(), indirect=["scratch"])
def test_the_page_does_what_it_says(page: str, scratch: Path, pytestconfig: pytest.Config) -> None:
    reader, text = Reader(), PAGES[page].read_text(encoding="utf-8")
    for block in blocks_of(PAGES[page]):
        try:
            if pytestconfig.getoption("--renew-pages"):
                text = text.replace(f"\n{block.text}```\n", f"\n{reader.renewed(block)}```\n", 1)
            else:
                reader.follow(block)
        except Exception as error:
            raise AssertionError(f"{page}:{block.line}: {error}") from error
    if text != PAGES[page].read_text(encoding="utf-8"):
        PAGES[page].write_text(text, encoding="utf-8")


@pytest.mark.parametrize("page", PAGES)
def test_marks_are_reasons_and_no_page_is_all_marks(page: str) -> None:
    blocks = [block for block in blocks_of(PAGES[page]) if not block.file]
    assert all(len(block.not_run.split()) > 2 for block in blocks if block.not_run)
    assert any(not block.not_run for block in blocks)


def test_two_of_three_blocks_are_run() -> None:
    blocks = [block for page in PAGES.values() for block in blocks_of(page) if not block.file]
    assert sum(not block.not_run for block in blocks) >= 2 / 3 * len(blocks)


def test_output_is_compared_by_words_numbers_and_order() -> None:
    said = "trials: 4 of 4 done, 2.3 s\nb 3.013 uV\nReport: /scratch/reports/mine/index.html\n"
    as_shown = ["trials: 4 of 4 done, 9.1 s", "...", "b 3.012 uV", "Report: reports/mine/index.html"]
    assert renewed_lines(as_shown, said) == as_shown
    assert renewed_lines(["trials: 70 of 70 done, ..."], said) == ["trials: 4 of 4 done, ..."]
    assert renewed_lines(["b 3.21 uV"], said) == ["b 3.013 uV"]
    for absent in (
        ["Report: reports/mine/index.html", "trials: 4 of 4"],
        ["fits: 4 of 4 done"],
        ["Report: theirs/index.html"],
    ):
        with pytest.raises(AssertionError, match="the page shows"):
            renewed_lines(absent, said)


def test_a_file_is_compared_too(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("table.csv").write_text("# sha256: 0123456789abcdef\n1,2.5\n")
    Reader().follow(Block(1, "text", "# sha256: fedcba9876543210\n1,2.5\n", shows="table.csv"))
    with pytest.raises(AssertionError, match=r"the page shows\n1,2.8\nbut it said\n1,2.5"):
        Reader().follow(Block(1, "text", "1,2.8\n", shows="table.csv"))


def test_a_page_that_shows_another_status_fails(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(AssertionError, match="status 2, expected 0"):
        Reader().follow(Block(1, "console", "$ emg2vsa fit absent.csv\n"))
    Reader().follow(Block(1, "console", "$ emg2vsa fit absent.csv\n", status=2))


def test_a_program_that_is_not_ours_asks_for_a_mark() -> None:
    with pytest.raises(AssertionError, match="mark the block as not run"):
        Reader().follow(Block(1, "sh", "rm -rf /nowhere\n"))


def test_python_shows_what_it_prints() -> None:
    Reader().follow(Block(1, "python", "print(1 + 1)  # 2\n"))
    with pytest.raises(AssertionError, match="the page shows"):
        Reader().follow(Block(1, "python", "print('two')  # three\n"))
