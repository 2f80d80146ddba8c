"""Programs of sub-commands: what is loaded, what is said, with which exit status."""

from __future__ import annotations

import argparse
import subprocess
import sys
from types import ModuleType

import pytest

from casr.command_line import Commands, Program, add_command, print_json
from casr.errors import SettingError
from emg2vsa.errors import StudyError

HEAVY = ("numpy", "scipy", "pandas", "cv2", "numba", "tifffile", "matplotlib", "pydantic")
REFUSED = SettingError("here", wanted="sense", found="none", do="Think.")


@pytest.fixture
def program(monkeypatch: pytest.MonkeyPatch) -> Program:
    """``toy go``, which raises what the test puts in ``toy.cli.go.raised``; and ``toy never``, which is not there."""

    def run(arguments: argparse.Namespace) -> int:
        raise module.raised

    def add_to(commands: Commands) -> None:
        add_command(commands, "go", run, "Go.")

    module = ModuleType("toy.cli.go")
    module.add_to = add_to  # type: ignore[attr-defined]
    for name in ("toy", "toy.cli", "toy.cli.go"):
        monkeypatch.setitem(sys.modules, name, module)
    return Program(name="toy", version="1", description="", epilog="", commands=("go", "never"), stopped="All is kept.")


@pytest.mark.parametrize(
    ("raised", "status", "said"),
    [
        (REFUSED, 2, "toy: here: expected sense, but found none. Think.\n"),
        (StudyError(("a: no", "b: no")), 2, "a: no\nb: no\n2 problems; nothing was run.\n"),
        (FileNotFoundError(2, "No such file", "x.csv"), 2, "toy: x.csv: No such file\n"),
        (KeyboardInterrupt(), 130, "\nStopped. All is kept.\n"),
    ],
)
def test_what_stops_a_command_is_said(
    program: Program, raised: BaseException, status: int, said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    sys.modules["toy.cli.go"].raised = raised  # type: ignore[attr-defined]
    assert program.main(["go"]) == status
    assert capsys.readouterr().err == said


def test_only_the_command_that_runs_is_loaded(program: Program) -> None:
    with pytest.raises(ModuleNotFoundError, match="never"):
        program.parser()
    assert program.parser(["go"]).parse_args(["go"]).run


def test_help_of_casr_loads_nothing_heavy() -> None:
    code = (
        f"import sys; from casr.cli import PROGRAM; PROGRAM.parser(); print([m for m in {HEAVY} if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_json_knows_no_nan(capsys: pytest.CaptureFixture[str]) -> None:
    print_json({"a": [float("nan"), 1.5], "b": float("inf")})
    assert capsys.readouterr().out.split() == ["{", '"a":', "[", "null,", "1.5", "],", '"b":', "null", "}"]
