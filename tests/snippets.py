"""Commands and Python of a page, and what the page shows of their output.

Blocks of ``console``, ``sh``, ``bash`` and ``python`` are run. Comments on the lines before a block say more::

    <!-- not run: it needs a rig -->        nobody runs the next block, for this reason
    <!-- first: emg2vsa tools sample plate -->    a command that a reader has run before
    <!-- change: study.toml: a -> b -->     what a reader has edited before
    <!-- file: study.toml -->               the next block, of any language, is this file
    <!-- status: 1 -->                      exit status of the commands of the next block, instead of 0
    <!-- shows: FILE -->                    the lines of the next block, of any language, stand in this file

What a page shows is compared word for word and number for number. ``...`` stands for words that are left out. Seconds
and digests differ from run to run, so any will do. ``pytest tests/test_snippets.py --renew-pages`` writes what is said
now into the pages.
"""

from __future__ import annotations

import contextlib
import glob
import io
import re
import shlex
import sys
import types
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import casr.cli
import emg2vsa.cli

PROGRAMS = {"emg2vsa": emg2vsa.cli.main, "casr": casr.cli.main}
LANGUAGES = ("console", "sh", "bash", "python")
_BLOCK = re.compile(r"((?:^<!-- .*? -->\n+)*)^```(\w+)\n(.*?)^```$", flags=re.M | re.S)
_NOTE = re.compile(r"^<!-- (not run|first|change|file|status|shows): (.*?) -->$", flags=re.M)
_PRINTED = re.compile(r"^( *print\(.*\)  # )(.*)$", flags=re.M)
_NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")
_DIGEST = re.compile(r"(?<![.\w])(?=[0-9]*[a-f])[0-9a-f]{12,}\b")
_TIMES = ("s", "min")


@dataclass(frozen=True)
class Block:
    """A fenced block. not_run : the reason, or "". file : what it is written to. shows : the file that it stands in."""

    line: int
    language: str
    text: str
    not_run: str = ""
    file: str = ""
    shows: str = ""
    status: int = 0
    first: tuple[tuple[str, str], ...] = ()


def blocks_of(page: Path) -> list[Block]:
    """The blocks that are run, marked, or written to a file."""
    text = page.read_text(encoding="utf-8")
    found = []
    for match in _BLOCK.finditer(text):
        notes = _NOTE.findall(match[1])
        said = dict(notes)
        if match[2] in LANGUAGES or {"file", "shows"} & set(said):
            block = Block(
                line=text[: match.start(2)].count("\n") + 1, language=match[2], text=match[3],
                not_run=said.get("not run", ""), file=said.get("file", ""), shows=said.get("shows", ""),
                status=int(said.get("status", 0)),
                first=tuple(note for note in notes if note[0] in ("first", "change")),
            )  # fmt: skip
            found.append(block)
    return found


@dataclass
class Reader:
    """Who follows a page in the present folder, block by block; Python keeps its names from block to block."""

    names: dict[str, Any] = field(init=False)

    def __post_init__(self) -> None:
        # a dataclass looks up the module that it stands in
        sys.modules["snippet"] = module = types.ModuleType("snippet")
        self.names = vars(module)

    def follow(self, block: Block) -> None:
        """Do what the block says; an AssertionError where it shows something else than is said."""
        now = self.renewed(block)
        old = [line for line, new in zip(block.text.splitlines(), now.splitlines(), strict=True) if line != new]
        new = [new for line, new in zip(block.text.splitlines(), now.splitlines(), strict=True) if line != new]
        assert now == block.text, "\n".join(["the page shows", *old, "but it said", *new])

    def renewed(self, block: Block) -> str:
        """The text of the block, as its page should show it: with what its commands say now."""
        for what, value in block.first:
            if what == "change":
                edit(value)
            else:
                status, said = run_command(value)
                assert status == 0, f"{value}: status {status}\n{said}"
        if block.not_run:
            return block.text
        if block.file:
            path = Path(block.file)
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(block.text, encoding="utf-8")
            return block.text
        if block.shows:
            lines = block.text.splitlines()
            return _text(renewed_lines(lines, Path(block.shows).read_text(encoding="utf-8")))
        return self._python(block) if block.language == "python" else self._commands(block)

    def _commands(self, block: Block) -> str:
        lines: list[str] = []
        for command, shown in commands_of(block):
            if command is not None:
                lines.append(command)
                command = command.removeprefix("$ ")
                status, said = run_command(command)
                assert status == block.status, f"{command}: status {status}, expected {block.status}\n{said}"
                lines += renewed_lines(shown, said)
            else:
                lines += shown
        return _text(lines)

    def _python(self, block: Block) -> str:
        said = io.StringIO()
        with contextlib.redirect_stdout(said):
            exec(compile(block.text, f"<block of line {block.line}>", "exec"), self.names)
        now = iter(renewed_lines([printed[2] for printed in _PRINTED.finditer(block.text)], said.getvalue()))
        return _PRINTED.sub(lambda printed: printed[1] + next(now), block.text)


def _text(lines: Sequence[str]) -> str:
    return "".join(f"{line}\n" for line in lines)


def edit(change: str) -> None:
    """Replace text in a file: ``FILE: OLD -> NEW``."""
    name, _, texts = change.partition(": ")
    old, _, new = texts.partition(" -> ")
    text = Path(name).read_text(encoding="utf-8")
    assert old in text, f"{name} holds no {old!r}"
    Path(name).write_text(text.replace(old, new), encoding="utf-8")


def commands_of(block: Block) -> list[tuple[str | None, list[str]]]:
    """Every command with the lines under it; of a block that is no session every line but comments is a command."""
    found: list[tuple[str | None, list[str]]] = []
    for line in block.text.splitlines():
        if line.startswith("$ ") or (block.language != "console" and line.strip() and not line.startswith("#")):
            found.append((line, []))
        elif block.language == "console":
            found[-1][1].append(line)
        else:
            found.append((None, [line]))
    return found


def run_command(command: str) -> tuple[int, str]:
    """Exit status and everything said, of ``emg2vsa`` or ``casr`` in this process."""
    program, *words = shlex.split(command, comments=True)
    assert program in PROGRAMS, f"{program}: mark the block as not run, with the reason"
    words = [path for word in words for path in (sorted(glob.glob(word)) or [word])]
    said = io.StringIO()
    with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
        try:
            status = PROGRAMS[program](words)
        except SystemExit as end:
            status = int(end.code or 0)
    return status, said.getvalue()


def renewed_lines(shown: Sequence[str], said: str) -> list[str]:
    """The lines shown, with the words and numbers that are said now; AssertionError where one is absent.

    A line that is said as shown is kept. Of another one the first three words tell which line it was, with any number.
    """
    left, lines = said.splitlines(), []
    for line in shown:
        if line.strip() in ("", "..."):
            lines.append(line)
            continue
        same = [at for at, other in enumerate(left) if _is_same(line, other)]
        like = [at for at, other in enumerate(left) if _is_alike(line, other)]
        assert same or like, f"the page shows\n{line}\nbut it said\n{said}"
        at = (same or like)[0]
        lines.append(line if same else _renewed(line, left[at]))
        left = left[at + 1 :]
    return lines


def _words(shown: str) -> tuple[list[str], bool]:
    """The words of a line that a page shows, and whether it leaves out what follows them."""
    words = shown.split()
    ends = next((at for at, word in enumerate(words) if word == "..." or (at and "..." in word)), None)
    return words[:ends], ends is not None


def _is_same(shown: str, said: str) -> bool:
    (wanted, is_part), found = _words(shown), said.split()
    return (len(wanted) == len(found) or (is_part and len(wanted) < len(found))) and all(
        _is_end(word, other) or _has_same_numbers(word, other) or _is_time(word, after)
        for word, other, after in zip(wanted, found, [*wanted[1:], ""], strict=False)
    )


def _is_alike(shown: str, said: str) -> bool:
    wanted, found = _words(shown)[0][:3], said.split()
    return len(found) >= len(wanted) and all(
        _is_end(word, other) or _bare(other) == _bare(word) for word, other in zip(wanted, found, strict=False)
    )


def _renewed(shown: str, said: str) -> str:
    """What is said, with the paths of the page, and up to the words that the page leaves out."""
    wanted, is_part = _words(shown)
    paths = {other: word for word, other in zip(wanted, said.split(), strict=False) if _is_end(word, other)}
    now = re.sub(r"\S+", lambda word: paths.get(word[0], word[0]), said.rstrip())
    if not is_part:
        return now
    first = re.match(rf"\s*(?:\S+\s+){{{len(wanted)}}}", now)
    return f"{first[0] if first else now}..."


def _is_end(shown: str, said: str) -> bool:
    """The page leaves out where a path begins."""
    return ("/" in shown and said.endswith(shown)) or (shown.startswith("...") and said.endswith(shown[3:]))


def _has_same_numbers(shown: str, said: str) -> bool:
    """The same word. A number with a point may differ by one in its last digit, or by half a percent."""
    if _bare(shown) != _bare(said):
        return False
    ours, theirs = (_NUMBER.findall(_DIGEST.sub("0", word)) for word in (shown, said))
    return all(_is_near(one, other) for one, other in zip(ours, theirs, strict=True))


def _is_near(one: str, other: str) -> bool:
    if "." not in one:
        return float(one) == float(other)
    digits, _, exponent = one.partition("e")
    last_digit = 10.0 ** (int(exponent or 0) - len(digits.partition(".")[2]))
    return abs(float(one) - float(other)) <= 1.001 * max(last_digit, 0.005 * abs(float(one)))


def _is_time(shown: str, after: str) -> bool:
    return after.rstrip(".,;") in _TIMES and _bare(shown) == "0"


def _bare(word: str) -> str:
    return _NUMBER.sub("0", _DIGEST.sub("0", word))
