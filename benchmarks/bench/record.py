"""Results of a benchmark as JSON, prose and tables apart, of which the documentation site makes pages.

``python -m benchmarks.NAME | python -m benchmarks.bench.record NAME`` keeps what a benchmark prints as
``benchmarks/results/NAME.json``; without input from a pipe it prints that record as Markdown.
"""

from __future__ import annotations

import argparse
import json
import re
import sys
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from casr.atomic import write_text_atomic

RESULTS = Path(__file__).resolve().parents[1] / "results"
_CELLS = re.compile(r"(?<!\\)\|")


def of_markdown(text: str) -> dict[str, Any]:
    """``title`` and ``blocks``: a text each, or a table with ``head``, ``right`` (of each column) and ``rows``."""
    title, _, rest = text.partition("\n")
    blocks: list[Any] = []
    for part in re.split(r"\n{2,}", rest.strip("\n")):
        lines = part.splitlines()
        start = next((i for i, line in enumerate(lines[:-1]) if line.startswith("|") and _rule(lines[i + 1])), None)
        if start is None:
            blocks.append(part)
            continue
        blocks += ["\n".join(lines[:start])] if start else []
        end = next((i for i in range(start, len(lines)) if not lines[i].startswith("|")), len(lines))
        head, rule, *rows = map(_cells, lines[start:end])
        blocks.append({"head": head, "right": [cell.endswith(":") for cell in rule], "rows": rows})
        blocks += ["\n".join(lines[end:])] if end < len(lines) else []
    return {"title": title.lstrip("# "), "blocks": blocks}


def markdown(record: dict[str, Any]) -> str:
    """The page of a record; a table without ``right`` has every column at the left."""
    parts = [f"# {record['title']}"]
    for block in record["blocks"]:
        if isinstance(block, str):
            parts.append(block)
        else:
            rule = ["---:" if right else "---" for right in block.get("right", [False] * len(block["head"]))]
            parts.append("\n".join(f"| {' | '.join(row)} |" for row in [block["head"], rule, *block["rows"]]))
    return "\n\n".join(parts) + "\n"


def keep(path: Path, text: str) -> None:
    """Write the record of a page in Markdown, whole or not at all."""
    write_text_atomic(path, json.dumps(of_markdown(text), indent=1, ensure_ascii=False) + "\n")


def print_page(about: str | None, page: Callable[[], Iterable[str]]) -> None:
    """``main`` of a benchmark: print its page of Markdown, line by line, and keep the record where ``--write`` says."""
    parser = argparse.ArgumentParser(description=about)
    parser.add_argument("--write", type=Path, metavar="FILE", help="a record of it there")
    path = parser.parse_args().write
    text = "\n".join(page())
    print(text)
    if path:
        keep(path, text)


def is_record(value: object) -> bool:
    """Whether JSON holds a record, and not the numbers that a benchmark works on."""
    return isinstance(value, dict) and value.keys() == {"title", "blocks"}


def _rule(line: str) -> bool:
    return re.fullmatch(r"\|(?: *:?-+:? *\|)+", line) is not None


def _cells(line: str) -> list[str]:
    return [cell.strip() for cell in _CELLS.split(line.strip()[1:-1])]


if __name__ == "__main__":
    file = RESULTS / f"{sys.argv[1]}.json"
    if sys.stdin.isatty():
        print(markdown(json.loads(file.read_text(encoding="utf-8"))), end="")
    else:
        keep(file, sys.stdin.read())
