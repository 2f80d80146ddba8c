"""The how-to: its commands run, and what they print looks as it says (numbers aside), where it says it."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest

from casr.cli import main

HOW_TO = Path(__file__).parents[3] / "docs" / "how-to" / "tactile.md"


def steps() -> list[tuple[str, str]]:
    """Every command of the console blocks in turn, and its output."""
    blocks = re.findall(r"```console\n(.*?)```", HOW_TO.read_text(encoding="utf-8"), flags=re.S)
    found = [part.partition("\n") for block in blocks for part in re.split(r"^\$ ", block, flags=re.M)[1:]]
    return [(command, output) for command, _, output in found]


def shape(text: str) -> list[str]:
    """Lines without their numbers and the spaces that line them up; notes aside."""
    return [re.sub(r"[-+\d.e ]+", " ", line).strip() for line in text.splitlines()]


@pytest.mark.slow
def test_every_command_does_what_the_page_says(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    for command, output in steps():
        program, *words = shlex.split(command)
        assert (program, main(words)) == ("casr", 0), command
        said = shape(capsys.readouterr().out)
        assert said == shape(output) or not output.strip(), command
    assert {path.name for path in tmp_path.iterdir()} == {
        "presses",
        "scores.html",
        "scores_pages",
        "press.html",
        "pictures",
        "pins.csv",
        "frames.csv",
    }
