"""All verbs of both programs: their help, their JSON, the older spellings, and what they load."""

from __future__ import annotations

import argparse
import json
import subprocess
import sys

import pytest

import casr.cli
import emg2vsa.cli
from casr.command_line import Program, SubCommands, parsers_of
from casr.terminal import VOICE

PROGRAMS = {program.name: program for program in (emg2vsa.cli.PROGRAM, casr.cli.PROGRAM)}
HEAVY = ("numpy", "scipy", "pandas", "matplotlib", "cv2", "numba", "starlette", "edfio")


def verbs(program: Program) -> list[argparse.ArgumentParser]:
    """Parsers of what runs, not of groups."""
    return [
        parser
        for parser in parsers_of(program.parser())
        if not any(isinstance(action, SubCommands) for action in parser._actions)
    ]


EVERY = pytest.mark.parametrize("parser", [each for p in PROGRAMS.values() for each in verbs(p)], ids=lambda p: p.prog)
OLDER = pytest.mark.parametrize(
    ("program", "old"), [(program, old) for program in PROGRAMS.values() for old in program.moved]
)


@pytest.fixture(autouse=True)
def _own_voice(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("quiet", "verbose", "json"):
        monkeypatch.setattr(VOICE, name, False)


def test_the_verbs_at_the_top_are_few() -> None:
    top = "new inspect check register run status report fit schedule stats session rig verify tools"
    assert list(emg2vsa.cli.PROGRAM.commands) == top.split()
    assert len(casr.cli.PROGRAM.commands) <= 11


@EVERY
def test_every_verb_has_help(parser: argparse.ArgumentParser, capsys: pytest.CaptureFixture[str]) -> None:
    name, *words = parser.prog.split()
    with pytest.raises(SystemExit) as ended:
        PROGRAMS[name].main([*words, "--help"])
    assert ended.value.code == 0
    said = capsys.readouterr()
    assert said.out.startswith(f"usage: {parser.prog} ")
    assert said.err == ""


@EVERY
def test_every_verb_has_json(parser: argparse.ArgumentParser) -> None:
    assert "--json" in parser._option_string_actions


@EVERY
def test_a_mistyped_option_of_every_verb_is_one_json_object_with_json(
    parser: argparse.ArgumentParser, capsys: pytest.CaptureFixture[str]
) -> None:
    name, *words = parser.prog.split()
    with pytest.raises(SystemExit) as ended:
        PROGRAMS[name].main([*words, "--jsonn-is-misspelt", "--json"])
    out, err = capsys.readouterr()
    told = json.loads(out)
    assert told["status"] == ended.value.code == 2
    assert err.startswith(f"usage: {parser.prog} ")
    assert told["error"]["message"].startswith(f"{parser.prog}: ")
    assert told["error"]["message"] in err


@OLDER
def test_an_older_spelling_runs_and_says_the_new_one(
    program: Program, old: str, capsys: pytest.CaptureFixture[str]
) -> None:
    said = {}
    for spelling in (old, program.moved[old]):
        with pytest.raises(SystemExit) as ended:
            program.main([*spelling.split(), "--help"])
        assert ended.value.code == 0
        said[spelling] = capsys.readouterr()
    first, second = said.values()
    assert first.out == second.out
    assert (first.err, second.err) == (f'{program.name}: "{program.name} {old}" is now "{program.name} '
                                       f'{program.moved[old]}".\n', "")  # fmt: skip


@OLDER
def test_an_older_spelling_is_not_in_the_help(program: Program, old: str) -> None:
    offered = [parser.prog for parser in parsers_of(program.parser())]
    assert f"{program.name} {old}" not in offered
    assert f"{program.name} {program.moved[old]}" in offered


def test_an_older_spelling_gives_the_same_result(capsys: pytest.CaptureFixture[str]) -> None:
    said = []
    for words in (["power", "--json"], ["tools", "power", "--json"]):
        assert emg2vsa.cli.main(words) == 0
        said.append(capsys.readouterr().out)
    assert said[0] == said[1] != ""
    assert emg2vsa.cli.main(["power", "--json", "--quiet"]) == 0
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize(
    "words", [["--help"], ["tools", "simulate", "--help"], *([name, "--help"] for name in emg2vsa.cli.PROGRAM.commands)]
)
def test_help_loads_nothing_heavy_and_only_what_is_asked_for(words: list[str]) -> None:
    code = (
        "import sys\nfrom emg2vsa.cli import main\ntry: main(sys.argv[1:])\nexcept SystemExit: pass\n"
        "print(*sys.modules, file=sys.stderr)"
    )
    done = subprocess.run([sys.executable, "-c", code, *words], capture_output=True, text=True, check=True)
    loaded = done.stderr.split()
    assert [name for name in HEAVY if name in loaded] == []
    assert ("emg2vsa.cli.rig" in loaded) is (words in (["--help"], ["rig", "--help"]))
    assert ("emg2vsa.cli.tools.sizes" in loaded) is (words == ["tools", "--help"])
