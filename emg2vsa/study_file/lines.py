"""Which line of a TOML file a key stands on; ``tomllib`` does not say."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping

KeyPath = tuple[str | int, ...]

_TOKEN = re.compile(
    r"""(?P<skip>[ \t\r]+|\#[^\n]*)
      | (?P<newline>\n)
      | (?P<text>\"{3}(?:\\.|[^\\])*?\"{3,5} | '{3}.*?'{3,5} | "(?:\\.|[^"\\\n])*" | '[^'\n]*')
      | (?P<mark>[\[\]{}=,.])
      | (?P<bare>[^\s\[\]{}=,.\#"']+)""",
    re.VERBOSE | re.DOTALL,
)


def key_lines(text: str) -> dict[KeyPath, int]:
    """Line (1-based) of every table, key and array element of ``text``, which must be valid TOML."""
    return _Scanner(text).document()


def line_of(path: KeyPath, lines: Mapping[KeyPath, int]) -> int:
    """Line of ``path``, or of the nearest table around it that the file holds; 1 where it holds none."""
    return next((lines[path[:n]] for n in range(len(path), 0, -1) if path[:n] in lines), 1)


class _Scanner:
    """A walk over the tokens; values matter only for where they end."""

    def __init__(self, text: str) -> None:
        self.tokens: list[tuple[str, int]] = []
        line = 1
        for match in _TOKEN.finditer(text):
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

    def document(self) -> dict[KeyPath, int]:
        table: KeyPath = ()
        while self.peek():
            if self.peek() == "\n":
                self.take()
            elif self.peek() == "[":
                table = self.header()
            else:
                self.pair(table)
        return self.lines

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
