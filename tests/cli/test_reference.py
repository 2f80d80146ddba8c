"""The pages of commands: current, and the same on every terminal."""

from __future__ import annotations

from types import ModuleType

import pytest

import casr.cli.reference
import emg2vsa.cli.reference
from casr.cli import PROGRAM as CASR
from casr.command_line import PAGE_COLUMNS
from emg2vsa.cli import PROGRAM as EMG2VSA
from emg2vsa.cli.rig import SUBCOMMANDS

PAGES = [casr.cli.reference, emg2vsa.cli.reference]


@pytest.mark.parametrize("page", PAGES)
def test_the_written_page_is_current(page: ModuleType) -> None:
    assert page.PATH.read_text(encoding="utf-8") == page.markdown(), f"run python -m {page.__name__}"


def test_every_command_has_its_section() -> None:
    text = "".join(page.markdown() for page in PAGES)
    names = [f"{program.name} {name}" for program in (CASR, EMG2VSA) for name in program.commands]
    names += [f"emg2vsa rig {name}" for name in SUBCOMMANDS]
    assert [name for name in names if f"\n## `{name}`\n" not in text] == []


@pytest.mark.parametrize("columns", ["40", "300"])
@pytest.mark.parametrize("page", PAGES)
def test_the_terminal_does_not_matter(page: ModuleType, columns: str, monkeypatch: pytest.MonkeyPatch) -> None:
    text = page.markdown()
    monkeypatch.setenv("COLUMNS", columns)
    assert page.markdown() == text
    assert max(map(len, text.split("```text")[1].splitlines())) <= PAGE_COLUMNS
