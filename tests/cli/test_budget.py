"""The command line stays thin: verbs parse, call and print; what they do is in the packages below."""

from __future__ import annotations

from pathlib import Path

import casr
import emg2vsa

MOST_OF_A_VERB, MOST_OF_EMG2VSA, MOST_IN_ALL = 80, 3800, 5400
SHARED = {"arguments.py", "values.py", "machines.py", "progress.py", "choice.py", "run_words.py"}
"Options, words and progress bars that several verbs share; they are no verbs."
KIT = ("command_line.py", "completion.py", "terminal.py")
CASR, EMG2VSA = Path(casr.__file__).parent, Path(emg2vsa.__file__).parent


def lines(path: Path) -> int:
    return len(path.read_text(encoding="utf-8").splitlines())


def test_no_verb_is_long() -> None:
    files = [path for package in (CASR, EMG2VSA) for path in (package / "cli").rglob("*.py")]
    long = {str(path): lines(path) for path in files if path.name not in SHARED}
    assert {path: count for path, count in long.items() if count > MOST_OF_A_VERB} == {}


def test_the_command_line_is_short() -> None:
    own, theirs = (sum(map(lines, (package / "cli").rglob("*.py"))) for package in (EMG2VSA, CASR))
    assert own <= MOST_OF_EMG2VSA
    assert own + theirs + sum(lines(CASR / name) for name in KIT) <= MOST_IN_ALL
