"""A TOML file: its text and tables, the line that each of its keys stands on, and problems said with their lines."""

from __future__ import annotations

import codecs
import contextlib
import os
import re
import tomllib
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from emg2vsa.errors import StudyError
from emg2vsa.study_file.problems import KeyPath, Problem


def beside(folder: Path, path: str) -> Path:
    """``path`` relative to ``folder``, without the dots; nothing of it need exist."""
    return Path(spelled_beside(folder, path))


def spelled_beside(folder: str | Path, path: str) -> str:
    """The same as text, for thousands of which few are kept."""
    return os.path.normpath(os.path.join(folder, path))


def reports_beside(folder: Path, name: str) -> Path:
    """Where the report of study ``name`` goes by default: two folders up from studies/<any>, else beside its file."""
    return beside(folder, f"../../reports/{name}" if folder.parent.name == "studies" else f"reports/{name}")


def read_toml(path: Path, what: str) -> tuple[str, dict[str, Any]]:
    """Text and tables of ``path``. StudyError when there is no ``what`` ("a study file") to read, or it is no TOML."""
    try:
        # line ends as TOML counts them and no byte order mark, whatever the editor wrote
        text = path.read_bytes().removeprefix(codecs.BOM_UTF8).decode("utf-8").replace("\r\n", "\n")
    except OSError as error:
        kind = what.removeprefix("a ")
        found = f"a folder. Name the {kind} in it" if path.is_dir() else f"no file that can be read ({error.strerror})"
        raise StudyError((f"{path}: expected {what}, but found {found}.",)) from None
    except UnicodeDecodeError as error:
        line = error.object[: error.start].count(b"\n") + 1
        raise StudyError(
            (f"{path}:{line}: expected UTF-8 text, but found byte 0x{error.object[error.start]:02x}.",)
        ) from None
    try:
        return text, tomllib.loads(text)
    except RecursionError:
        raise StudyError(
            (f"{path}: expected valid TOML, but found brackets within brackets by the hundred.",)
        ) from None
    except ValueError as error:  # TOMLDecodeError, or a whole number that Python does not read
        found = re.sub(r" \(at [^(]*\)$", "", str(error))
        digits = re.findall(r"\d+", str(error)[len(found) :]) or [str(text.count("\n") + 1)]
        raise StudyError((f"{path}:{':'.join(digits)}: expected valid TOML, but the parser says: {found}.",)) from None


def placed(path: Path, text: str, problems: Iterable[Problem]) -> StudyError:
    """The error that lists all problems of a file, in the order of its lines."""
    lines = key_lines(text)
    by_line = sorted(((line_of(p.path, lines), str(p)) for p in problems), key=lambda item: item[0])
    return StudyError(tuple(f"{path}:{line}: {problem}" for line, problem in by_line))


def key_lines(text: str) -> dict[KeyPath, int]:
    """Line (1-based) of every table, key and array element of ``text``, which must be valid TOML."""
    scanner = _Scanner(text)
    with contextlib.suppress(RecursionError):  # brackets within brackets: those above them have their lines
        scanner.document()
    return scanner.lines


def line_of(path: KeyPath, lines: Mapping[KeyPath, int]) -> int:
    """Line of ``path``, or of the nearest table around it that the file holds; 1 where it holds none."""
    return next((lines[path[:n]] for n in range(len(path), 0, -1) if path[:n] in lines), 1)


class _Scanner:
    """A walk over the tokens; values matter only for where they end."""

    def __init__(self, text: str) -> None:
        self.tokens: list[tuple[str, int]] = []
        line = 1
        for match in re.finditer(_TOKEN, text, re.VERBOSE | re.DOTALL):
            if match.lastgroup != "skip":
                self.tokens.append((match.group(), line))
            line += match.group().count("\n")
        self.tokens.append(("", line))
        self.at = 0
        self.lines: dict[KeyPath, int] = {}
        self.array_sizes: dict[KeyPath, int] = {}

    def peek(self) -> str:
        return self.tokens[self.at][0]

    def take(self) -> str:
        self.at += 1
        return self.tokens[self.at - 1][0]

    def mark(self, path: KeyPath) -> None:
        for n in range(1, len(path) + 1):
            self.lines.setdefault(path[:n], self.tokens[self.at][1])

    def document(self) -> None:
        table: KeyPath = ()
        while self.peek():
            if self.peek() == "\n":
                self.take()
            elif self.peek() == "[":
                table = self.header()
            else:
                self.pair(table)

    def header(self) -> KeyPath:
        """``[a.b]`` or ``[[a.b]]``; the path of the table that it opens."""
        start = self.at
        self.take()
        is_array = self.peek() == "["
        if is_array:
            self.take()
        parts = self.key()
        self.at += 2 if is_array else 1
        end, self.at = self.at, start
        path: KeyPath = ()
        for depth, part in enumerate(parts, 1):
            path += (part,)
            if is_array and depth == len(parts):
                self.array_sizes[path] = self.array_sizes.get(path, 0) + 1
            if path in self.array_sizes:
                self.mark(path)
                path += (self.array_sizes[path] - 1,)
        self.mark(path)
        self.at = end
        return path

    def key(self) -> tuple[str, ...]:
        parts = [_key_text(self.take())]
        while self.peek() == ".":
            self.take()
            parts.append(_key_text(self.take()))
        return tuple(parts)

    def pair(self, table: KeyPath) -> None:
        start = self.at
        path = table + self.key()
        end, self.at = self.at, start
        self.mark(path)
        self.at = end + 1
        self.value(path)

    def value(self, path: KeyPath) -> None:
        if self.peek() == "[":
            self.array(path)
        elif self.peek() == "{":
            self.inline_table(path)
        else:
            while self.peek() not in ("", "\n", ",", "]", "}"):
                self.take()

    def array(self, path: KeyPath) -> None:
        self.take()
        index = 0
        while self.peek() != "]":
            if self.peek() in ("\n", ","):
                self.take()
                continue
            self.mark((*path, index))
            self.value((*path, index))
            index += 1
        self.take()

    def inline_table(self, path: KeyPath) -> None:
        self.take()
        while self.peek() != "}":
            if self.peek() in ("\n", ","):
                self.take()
                continue
            self.pair(path)
        self.take()


def _key_text(token: str) -> str:
    return next(iter(tomllib.loads(f"{token} = 0")))


_TOKEN = r"""(?P<skip>[ \t\r]+|\#[^\n]*)
    | (?P<newline>\n)
    | (?P<text>\"{3}(?:\\.|[^\\])*?\"{3,5} | '{3}.*?'{3,5} | "(?:\\.|[^"\\\n])*" | '[^'\n]*')
    | (?P<mark>[\[\]{}=,.])
    | (?P<bare>[^\s\[\]{}=,.\#"']+)"""
