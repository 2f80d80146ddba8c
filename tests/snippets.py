"""Commands and Python of a page, and what the page shows of their output.

Blocks of ``console``, ``sh``, ``bash`` and ``python`` are run. Comments on the lines before a block say more::

    <!-- not run: it needs a rig -->        nobody runs the next block, for this reason
    <!-- first: emg2vsa tools sample plate -->    a command that a reader has run before
    <!-- change: study.toml: a -> b -->     what a reader has edited before
    <!-- file: study.toml -->               the next block, of any language, is this file
    <!-- status: 1 -->                      exit status of the commands of the next block, instead of 0
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
_NOTE = re.compile(r"^<!-- (not run|first|change|file|status): (.*?) -->$", flags=re.M)


@dataclass(frozen=True)
class Block:
    """A fenced block. not_run : the reason, "" where it is run. file : what it is written to instead, or ""."""

    line: int
    language: str
    text: str
    not_run: str = ""
    file: str = ""
    status: int = 0
    first: tuple[tuple[str, str], ...] = ()


def blocks_of(page: Path) -> list[Block]:
    """The blocks that are run, marked, or written to a file."""
    text = page.read_text(encoding="utf-8")
    found = []
    for match in _BLOCK.finditer(text):
        notes = _NOTE.findall(match[1])
        said = dict(notes)
        if match[2] in LANGUAGES or "file" in said:
            block = Block(
                line=text[: match.start(2)].count("\n") + 1, language=match[2], text=match[3],
                not_run=said.get("not run", ""), file=said.get("file", ""), status=int(said.get("status", 0)),
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
        for what, value in block.first:
            if what == "change":
                edit(value)
            else:
                status, said = run_command(value)
                assert status == 0, f"{value}: status {status}\n{said}"
        if block.not_run:
            return
        if block.file:
            path = Path(block.file)
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(block.text, encoding="utf-8")
        elif block.language == "python":
            self._python(block)
        else:
            for command, shown in commands_of(block):
                status, said = run_command(command)
                assert status == block.status, f"{command}: status {status}, expected {block.status}\n{said}"
                absent = first_absent(shown, said)
                assert absent is None, f"{command}: the page shows\n{absent}\nbut it said\n{said}"

    def _python(self, block: Block) -> None:
        said = io.StringIO()
        with contextlib.redirect_stdout(said):
            exec(compile(block.text, f"<block of line {block.line}>", "exec"), self.names)
        shown = re.findall(r"^print\(.*\)  # (.*)$", block.text, flags=re.M)
        absent = first_absent(shown, said.getvalue())
        assert absent is None, f"line {block.line}: the page shows\n{absent}\nbut it said\n{said.getvalue()}"


def edit(change: str) -> None:
    """Replace text in a file: ``FILE: OLD -> NEW``."""
    name, _, texts = change.partition(": ")
    old, _, new = texts.partition(" -> ")
    text = Path(name).read_text(encoding="utf-8")
    assert old in text, f"{name} holds no {old!r}"
    Path(name).write_text(text.replace(old, new), encoding="utf-8")


def commands_of(block: Block) -> list[tuple[str, list[str]]]:
    """Every command with the output lines under it; of a block that is no session every line is a command."""
    found: list[tuple[str, list[str]]] = []
    for line in block.text.splitlines():
        if block.language != "console":
            if line.strip() and not line.startswith("#"):
                found.append((line, []))
        elif line.startswith("$ "):
            found.append((line[2:], []))
        else:
            found[-1][1].append(line)
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


def first_absent(shown: Sequence[str], said: str) -> str | None:
    """The first line shown that does not follow in what was said; None where all do, in their order.

    A line is known by its first three words, with any number for a number and the end of a path for the path.
    """
    left = iter(said.splitlines())
    for line in shown:
        if line.strip() not in ("", "...") and not any(_alike(line, other) for other in left):
            return line
    return None


def _alike(shown: str, said: str) -> bool:
    wanted, found = shown.split("...")[0].split()[:3], said.split()
    return len(found) >= len(wanted) and all(
        _bare(other).endswith(_bare(word)) if "/" in word else _bare(other) == _bare(word)
        for word, other in zip(wanted, found, strict=False)
    )


def _bare(word: str) -> str:
    return re.sub(r"[-+]?\d+([.,:]\d+)*(e[-+]?\d+)?", "0", word)
