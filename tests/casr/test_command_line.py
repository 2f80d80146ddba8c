"""Programs of sub-commands: what is loaded, what is said, with which exit status."""

from __future__ import annotations

import argparse
import json
import shutil
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import pytest

import casr.cli
import emg2vsa.cli
from casr.command_line import SHELLS, Commands, Program, add_command, add_json, add_options, completion, print_json
from casr.errors import SettingError
from casr.terminal import VOICE, coloured, note
from emg2vsa.errors import StudyError

HEAVY = ("numpy", "scipy", "pandas", "cv2", "numba", "tifffile", "matplotlib", "pydantic")
BASH = shutil.which("bash")
REFUSED = SettingError("here", wanted="sense", found="none", do="Think.")


@pytest.fixture
def program(monkeypatch: pytest.MonkeyPatch) -> Program:
    """``toy go``, which raises what the test puts in ``toy.cli.go.raised``; and ``toy never``, which is not there."""

    def run(arguments: argparse.Namespace) -> int:
        raise module.raised

    def add_to(commands: Commands) -> None:
        add_json(add_command(commands, "go", run, "Go."))

    module = ModuleType("toy.cli.go")
    module.add_to = add_to  # type: ignore[attr-defined]
    for name in ("toy", "toy.cli", "toy.cli.go"):
        monkeypatch.setitem(sys.modules, name, module)
    return Program(
        name="toy", version="1", description="", epilog="", commands=("go", "never"), stopped="All is kept.",
        extras={"parrots": "birds"}, moved={"walk": "go", "walk far": "go"},
    )  # fmt: skip


@pytest.fixture(autouse=True)
def _own_voice(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(VOICE, "quiet", False)
    monkeypatch.setattr(VOICE, "verbose", False)
    monkeypatch.setattr(VOICE, "json", False)
    for name in ("NO_COLOR", "FORCE_COLOR"):
        monkeypatch.delenv(name, raising=False)


STOPS = pytest.mark.parametrize(
    ("raised", "status", "said"),
    [
        (REFUSED, 2, "toy: here: expected sense, but found none. Think.\n"),
        (StudyError(("a: no", "b: no")), 2, "a: no\nb: no\n2 problems; nothing was run.\n"),
        (FileNotFoundError(2, "No such file", "x.csv"), 2, "toy: x.csv: No such file\n"),
        (
            ModuleNotFoundError("No module named 'parrots.beak'", name="parrots.beak"),
            2,
            'toy: expected the library parrots, but found none. Install it: pip install ".[birds]" in the folder of '
            "the sources.\n",
        ),
        (KeyboardInterrupt(), 130, "\nStopped. All is kept.\n"),
    ],
)


@STOPS
def test_what_stops_a_command_is_said(
    program: Program, raised: BaseException, status: int, said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    sys.modules["toy.cli.go"].raised = raised  # type: ignore[attr-defined]
    assert program.main(["go"]) == status
    assert capsys.readouterr().err == said


@STOPS
def test_what_stops_a_command_is_one_json_object_where_json_was_asked_for(
    program: Program, raised: BaseException, status: int, said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    sys.modules["toy.cli.go"].raised = raised  # type: ignore[attr-defined]
    assert program.main(["go", "--json"]) == status
    out, err = capsys.readouterr()
    assert err == said
    told = json.loads(out)
    assert told["status"] == status
    assert told["error"]["message"] in said.replace("toy: ", "")


def test_the_parts_of_an_error_are_told_apart(program: Program, capsys: pytest.CaptureFixture[str]) -> None:
    for raised, parts in (
        (REFUSED, {"what": "here", "wanted": "sense", "found": "none", "do": "Think."}),
        (StudyError(("a: no", "b: no")), {"problems": ["a: no", "b: no"]}),
    ):
        sys.modules["toy.cli.go"].raised = raised  # type: ignore[attr-defined]
        program.main(["go", "--json"])
        assert json.loads(capsys.readouterr().out) == {"error": {"message": str(raised)} | parts, "status": 2}


@pytest.mark.parametrize("words", [["go", "--nix", "--json"], ["--json"], ["nix", "--json"]])
def test_a_usage_error_is_json_too(program: Program, words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        program.main(words)
    out, err = capsys.readouterr()
    told = json.loads(out)
    assert told["status"] == ended.value.code == 2
    assert told["error"]["message"] in err


@pytest.mark.parametrize(("old", "quiet"), [("walk", False), ("walk far", False), ("walk", True)])
def test_an_older_spelling_runs_and_says_the_one_of_today(
    program: Program, old: str, quiet: bool, capsys: pytest.CaptureFixture[str]
) -> None:
    sys.modules["toy.cli.go"].raised = REFUSED  # type: ignore[attr-defined]
    assert program.main([*old.split(), *["-q"] * quiet]) == 2
    note = "" if quiet else f'toy: "toy {old}" is now "toy go".\n'
    assert capsys.readouterr().err == note + "toy: here: expected sense, but found none. Think.\n"


def test_options_from_a_table() -> None:
    parser = argparse.ArgumentParser()
    table = """
study STUDY  study file
parts [PART...]  all but for these,
  or none
-o --out DIR = here  folder
--gain X = 1  of 100 %%
--only {a,b} = b  one of them
--name NAME=K...  again and again
--count N  how many
--fast  at once
"""
    add_options(parser, table, {"N": int}, count={"default": 3})
    found = vars(parser.parse_args(["s.toml", "p", "q", "--name", "x=1", "--name", "y=2"]))
    assert found == {
        "study": Path("s.toml"), "parts": ["p", "q"], "out": Path("here"), "gain": 1.0, "only": "b",
        "name": ["x=1", "y=2"], "count": 3, "fast": False,
    }  # fmt: skip
    assert parser.parse_args(["s.toml", "--fast", "--count", "7"]).count == 7
    assert "all but for these, or none" in parser.format_help()
    assert "of 100 %" in parser.format_help()
    with pytest.raises(SystemExit):
        parser.parse_args(["s.toml", "--only", "c"])


def test_a_module_of_no_extra_is_a_fault_of_the_program(program: Program) -> None:
    sys.modules["toy.cli.go"].raised = ModuleNotFoundError("No module named 'toy.x'", name="toy.x")  # type: ignore[attr-defined]
    with pytest.raises(ModuleNotFoundError):
        program.main(["go"])


def test_verbose_says_where_an_error_arose(program: Program, capsys: pytest.CaptureFixture[str]) -> None:
    sys.modules["toy.cli.go"].raised = REFUSED  # type: ignore[attr-defined]
    assert program.main(["go", "--verbose"]) == 2
    said = capsys.readouterr().err
    assert "test_command_line.py" in said
    assert said.endswith("toy: here: expected sense, but found none. Think.\n")


def test_quiet_leaves_notes_out(program: Program, capsys: pytest.CaptureFixture[str]) -> None:
    sys.modules["toy.cli.go"].raised = REFUSED  # type: ignore[attr-defined]
    for words, told in ((["go"], "by the way\n"), (["go", "-q"], "")):
        program.main(words)
        capsys.readouterr()
        note("by the way")
        assert capsys.readouterr().err == told


@pytest.mark.parametrize(
    ("environment", "terminal", "colour"),
    [
        ({}, True, True),
        ({}, False, False),
        ({"NO_COLOR": "1"}, True, False),
        ({"TERM": "dumb"}, True, False),
        ({"FORCE_COLOR": "1"}, False, True),
        ({"FORCE_COLOR": "1", "NO_COLOR": "1"}, True, False),
    ],
)
def test_colours(monkeypatch: pytest.MonkeyPatch, environment: dict[str, str], terminal: bool, colour: bool) -> None:
    monkeypatch.setenv("TERM", "xterm")
    for name, value in environment.items():
        monkeypatch.setenv(name, value)
    monkeypatch.setattr(sys.stdout, "isatty", lambda: terminal, raising=False)
    assert coloured("word", "bad", sys.stdout) == ("\x1b[1;31mword\x1b[0m" if colour else "word")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["runn", "x"], "but found 'runn'. Did you mean run?"),
        (["run", "x", "--only", "fitz"], "but found 'fitz'. Did you mean fits?"),
        (["run", "x", "--jbos", "2"], "unrecognized arguments: --jbos 2. Did you mean --jobs?"),
        (["rig", "rnu"], "Did you mean run?"),
        (["session", "finsh"], "Did you mean finish?"),
        (["run", "x", "y"], "unrecognized arguments: y.\n"),
        (["-q", "run", "x"], "unrecognized arguments: -q. Write -q after emg2vsa run.\n"),
    ],
)
def test_a_mistyped_word_is_answered_with_the_nearest(
    words: list[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as ended:
        emg2vsa.cli.main(words)
    assert ended.value.code == 2
    assert said in capsys.readouterr().err


@pytest.mark.parametrize("program", [emg2vsa.cli.PROGRAM, casr.cli.PROGRAM], ids=["emg2vsa", "casr"])
@pytest.mark.parametrize("shell", SHELLS)
def test_completion_knows_every_command(program: Program, shell: str) -> None:
    script = completion(program, shell)
    assert [name for name in program.commands if name not in script] == []


@pytest.mark.skipif(BASH is None, reason="no bash")
@pytest.mark.parametrize(
    ("typed", "completed"),
    [
        ("emg2vsa ru", ["run"]),
        ("emg2vsa rig em", ["emulate"]),
        ("emg2vsa tools sim", ["simulate"]),
        ("emg2vsa sim", []),
        ("emg2vsa run s.toml --exp", ["--explain"]),
        ("emg2vsa run --only fi", ["fits"]),
        ("emg2vsa run stu", ["study.toml"]),
    ],
)
def test_completion_in_bash(tmp_path: Path, typed: str, completed: list[str]) -> None:
    (tmp_path / "study.toml").touch()
    (tmp_path / "completion").write_text(completion(emg2vsa.cli.PROGRAM, "bash"))
    words = typed.split()
    ask = f"COMP_WORDS=({typed}); COMP_CWORD={len(words) - 1}; _shtab_emg2vsa; "
    ask = f'source ./completion; {ask} echo "${{COMPREPLY[@]}}"'
    done = subprocess.run([str(BASH), "-c", ask], cwd=tmp_path, capture_output=True, text=True, check=True)
    assert done.stdout.split() == completed


def test_only_the_command_that_runs_is_loaded(program: Program) -> None:
    with pytest.raises(ModuleNotFoundError, match="never"):
        program.parser().format_help()
    assert program.parser().parse_args(["go"]).run


def test_help_of_casr_loads_nothing_heavy() -> None:
    code = (
        "import sys; from casr.cli import PROGRAM; PROGRAM.parser().format_help(); "
        f"print([m for m in {HEAVY} if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_json_knows_no_nan(capsys: pytest.CaptureFixture[str]) -> None:
    print_json({"a": [float("nan"), 1.5], "b": float("inf")})
    assert capsys.readouterr().out.split() == ["{", '"a":', "[", "null,", "1.5", "],", '"b":', "null", "}"]


@pytest.mark.parametrize("word", ["--json", "--js", "--jso"])
def test_errors_are_json_however_json_was_asked_for(
    program: Program, word: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit):
        program.main(["go", word, "--nothing"])
    told = json.loads(capsys.readouterr().out)
    assert told["status"] == 2
    assert "unrecognized arguments: --nothing" in told["error"]["message"]


def test_a_mistyped_older_spelling_is_known(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        emg2vsa.cli.main(["simulat"])
    assert "Did you mean simulate?" in capsys.readouterr().err
