"""Do folders of palpation reach a report: twelve of the gallery, and those that were kept apart from its rules?

A made person of each laboratory types commands and changes lines of the drafted study file, but only those that it
marks; a second one answers the questions of ``emg2vsa new --ask``. Prints Markdown.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import json
import re
import shlex
import statistics
import sys
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from importlib.util import find_spec
from pathlib import Path

from benchmarks import folders_apart, folders_gallery
from benchmarks.folder_laboratory import Known, Laboratory
from emg2vsa.cli import main
from emg2vsa.study import Study
from emg2vsa.study_file import load_study

MOST_EDITS, MOST_COMMANDS = 3, 5
_SLOPE_WITHIN = 0.25
"""A median b farther from the truth has a wrong unit, sign or channel."""


@dataclass
class Outcome:
    """commands : typed, in order. edits : lines changed. answers : typed; Enter alone is none. found, made : presses.

    slope : median b of the report over the true one. failed : where it ended, or "".
    """

    commands: list[str] = field(default_factory=list)
    edits: int = 0
    answers: int = 0
    questions: int = 0
    found: int = 0
    made: int = 0
    slope: float = float("nan")
    failed: str = ""

    @property
    def reached(self) -> bool:
        few = self.edits <= MOST_EDITS and len(self.commands) <= MOST_COMMANDS
        return not self.failed and few and self.found == self.made and abs(self.slope - 1) < _SLOPE_WITHIN


def try_folder(laboratory: Laboratory, folder: Path) -> Outcome:
    """Make the folder, and go from ``new`` to the report, then once more as far as the study file by answers."""
    laboratory.make(folder)
    outcome = Outcome(made=laboratory.people * len(laboratory.slope_v) * laboratory.presses)
    known, study_file = laboratory.known, folder / "study.toml"
    try:
        given = [word for name, k in known.stiffness_n_per_mm.items() for word in ("--stiffness", f"{name}={k:g}")]
        _type(outcome, ["new", str(folder), *given, "--no-questions"])
        text = study_file.read_text(encoding="utf-8")
        filled = completed(text, known)
        outcome.edits = sum(a != b for a, b in zip(text.splitlines(), filled.splitlines(), strict=True))
        study_file.write_text(filled, encoding="utf-8")
        judged = json.loads(_type(outcome, ["check", str(study_file), "--json"]))
        outcome.found = sum(each["found"] for person in judged.values() for each in person["specimens"])
        _run(outcome, study_file)
        study = load_study(study_file)
        if not (study.reports / "index.html").is_file():
            raise RuntimeError("no report")
        outcome.slope = _slope(study, laboratory)
        if len(study.participants) != laboratory.people:
            raise RuntimeError(f"participants {', '.join(study.participants)}")
        _answer(outcome, known, folder, study)
    except RuntimeError as error:
        outcome.failed = str(error).replace(f"{folder}/", "")
    return outcome


def completed(text: str, known: Known) -> str:
    """The study file with its marked lines as the people of the laboratory know them; others stay."""
    lines, is_force = [], False
    for line in text.splitlines():
        is_force = line == "[channels.force]" or (is_force and not line.startswith("["))
        if "FILL IN" in line and not line.startswith("#"):
            key = line.partition(" = ")[0]
            unit = known.force_unit if is_force else known.emg_unit
            values = {"name": json.dumps(known.force), "fs_hz": f"{known.fs_hz or 0:g}"}
            if key in ("unit", "newtons_per_unit"):
                is_number = unit[0].isdecimal()
                key, values[key] = ("newtons_per_unit", unit) if is_number else ("unit", json.dumps(unit))
                values.setdefault(key, unit if is_number else json.dumps(unit))
            if key in values:
                new = f"{key} = {values[key]}"
                line = line if line.startswith((f"{new} ", f"{new}.0 ")) else new
        lines.append(line)
    return "\n".join(lines) + "\n"


def of_name(values: Mapping[str, float], name: str) -> float:
    """The value of the one key that ends the name; 0 for none."""
    return next((value for key, value in values.items() if name.endswith(key)), 0.0)


def _type(outcome: Outcome, words: list[str]) -> str:
    """What a command prints. RuntimeError where it cannot be done."""
    outcome.commands.append(f"emg2vsa {shlex.join(words)}")
    said, wrong = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(said), contextlib.redirect_stderr(wrong):
        status = main(words)
    if status > 1 or (status and words[0] == "run"):
        last = wrong.getvalue().strip().splitlines()
        raise RuntimeError(f"{words[0]}: {last[-1] if last else status}")
    return said.getvalue()


def _run(outcome: Outcome, study_file: Path) -> None:
    """``run``, and once more where it asks for that, as files of the installation changed meanwhile."""
    words = ["run", str(study_file), "--quiet"]
    try:
        _type(outcome, words)
    except RuntimeError as error:
        if "Run the study again" not in str(error):
            raise
        _type(outcome, words)


class _Person(io.StringIO):
    """Answers at a terminal: reads the question that was printed last, and presses Enter where the guess is right."""

    def __init__(self, known: Known, screen: io.StringIO) -> None:
        super().__init__()
        self.known, self.screen, self.read, self.typed, self.asked = known, screen, 0, 0, 0

    def readline(self, size: int = -1, /) -> str:
        question = self.screen.getvalue()[self.read :]
        self.read = len(self.screen.getvalue())
        answer = self._answer(question)
        guess = re.search(r"\(Enter: ([^()]*)\)\s*> $", question)
        right = guess is not None and guess[1] == answer
        self.asked += 1
        self.typed += bool(answer) and not right
        return ("" if right else answer) + "\n"

    def _answer(self, question: str) -> str:
        known = self.known
        if match := re.search(r"Stiffness of (\S+)", question):
            return f"{of_name(known.stiffness_n_per_mm, match[1]):g}"
        if "what was pressed" in question:
            pressed = question.partition("what was pressed:")[2].split("\n")[0].split(",")[0].strip()
            return "yes" if pressed.endswith(tuple(known.stiffness_n_per_mm)) else next(iter(known.stiffness_n_per_mm))
        if "force that presses" in question:
            return known.force
        if "raise or lower" in question:
            return "lowers" if known.down else "raises"
        if "V, mV or uV" in question:
            return known.emg_unit
        if "newtons" in question:
            return known.force_unit
        if "samples are there in a second" in question:
            return f"{known.fs_hz:g}"
        return ""


def _answer(outcome: Outcome, known: Known, folder: Path, filled: Study) -> None:
    """The dialogue, whose study must have the channels and the stiffness of the one that was filled in."""
    screen, study_file = io.StringIO(), folder / "asked.toml"
    person, stdin = _Person(known, screen), sys.stdin
    sys.stdin = person
    try:
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(screen):
            status = main(["new", str(folder), "--ask", "--out", str(study_file), "--name", filled.name])
    finally:
        sys.stdin = stdin
    outcome.answers, outcome.questions = person.typed, person.asked
    if status:
        raise RuntimeError(f"new --ask: {screen.getvalue().strip().splitlines()[-1]}")
    asked = load_study(study_file)
    for name in ("participants", "stiffness_n_per_mm"):
        if getattr(asked, name) != getattr(filled, name):
            raise RuntimeError(f"new --ask: {name} {getattr(asked, name)}, not {getattr(filled, name)}")
    if [each.channels for each in asked.recordings] != [each.channels for each in filled.recordings]:
        raise RuntimeError("new --ask: other channels")


def _slope(study: Study, laboratory: Laboratory) -> float:
    import emg2vsa

    fits = emg2vsa.load(study.path).fits
    true_v = fits["specimen"].map(lambda name: of_name(laboratory.slope_v, name))
    return statistics.median(fits[next(c for c in fits if c.startswith("b_v") or c == "b")] / true_v)


_ABOUT = """\
A made person types `emg2vsa new FOLDER` with the stiffness of the objects, changes the marked lines of the study file
that are wrong (edits), and types `check` and `run`. A second one answers the questions of `new --ask`: Enter where the
guess is right, else the answer is typed (stiffness always is); both study files must have the same channels and people.
A report counts where every press was found, and where the median of b over the true b shows no wrong unit, sign or
channel."""
_SETS = {
    "The gallery": (list(folders_gallery.LABORATORIES.values()), "`new` was written with these."),
    "Kept apart": (
        list(folders_apart.LABORATORIES),
        "Made before the rules of `new` were read. When it first met them, 4 of 10 reached a report; causes that other "
        "folders share were mended then. The armband's channels, which were copies by mistake, were made anew.",
    ),
    "Kept apart, later": (
        list(folders_apart.LATER), "Made after that. When it first met them, 3 of 6 reached a report.",
    ),
    "Kept apart to the last": (list(folders_apart.LAST), "Made after that again, and `new` was not changed for them."),
}  # fmt: skip


def _table(title: str, tried: Sequence[tuple[Laboratory, Outcome]]) -> Iterator[str]:
    yield f"## {title}\n"
    yield "| folder | laboratory | commands | edits | questions; answers typed | presses | b / true b | report |"
    yield "|---|---|--:|--:|--:|--:|--:|---|"
    for laboratory, o in tried:
        end = "yes" if o.reached else o.failed or "not as wanted"
        cells = (
            len(o.commands),
            o.edits,
            f"{o.questions}; {o.answers}",
            f"{o.found} of {o.made}",
            f"{o.slope:.3f}",
            end,
        )
        yield f"| {laboratory.name} | {laboratory.what} | {' | '.join(map(str, cells))} |"
    reached = sum(outcome.reached for _, outcome in tried)
    yield f"\n{reached} of {len(tried)} reach a report with at most {MOST_EDITS} edits and {MOST_COMMANDS} commands.\n"


def run() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", help="folders to try (default: all)")
    names = parser.parse_args().names
    print(f"# Folders of laboratories, from `emg2vsa new` to a report\n\n{_ABOUT}\n")
    for title, (laboratories, about) in _SETS.items():
        chosen = [each for each in laboratories if not names or each.name in names]
        if find_spec("neo") is None:
            chosen = [each for each in chosen if each.name != "spike2"]
        tried = []
        for laboratory in chosen:
            with tempfile.TemporaryDirectory() as folder:
                (place := Path(folder) / laboratory.name).mkdir()
                tried.append((laboratory, try_folder(laboratory, place)))
        print("\n".join(_table(f"{title}\n\n{about}", tried)))


if __name__ == "__main__":
    run()
