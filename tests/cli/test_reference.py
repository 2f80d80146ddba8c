"""The page of commands: current, and the same on every terminal."""

from __future__ import annotations

import pytest

from emg2vsa.cli import COMMANDS
from emg2vsa.cli.reference import PATH, WIDTH, markdown
from emg2vsa.cli.rig import SUBCOMMANDS


def test_the_written_page_is_current() -> None:
    assert PATH.read_text(encoding="utf-8") == markdown(), "run python -m emg2vsa.cli.reference"


def test_every_command_has_its_section() -> None:
    text = markdown()
    names = [*COMMANDS, *(f"rig {name}" for name in SUBCOMMANDS)]
    assert [name for name in names if f"\n## `emg2vsa {name}`\n" not in text] == []


@pytest.mark.parametrize("columns", ["40", "300"])
def test_the_terminal_does_not_matter(columns: str, monkeypatch: pytest.MonkeyPatch) -> None:
    text = markdown()
    monkeypatch.setenv("COLUMNS", columns)
    assert markdown() == text
    assert max(map(len, text.split("```text")[1].splitlines())) <= WIDTH
